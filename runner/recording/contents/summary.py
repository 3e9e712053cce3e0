"""The summary section of an MCAP file, as its records require it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from mcap import records

from slipmode.runner.recording.contents.layout import MessageIndex


class Summary:
    """Collects the records of a summary while the data section is written or checked.

    Attributes
    ----------
    records : list of records
        Schemas, channels and the indexes of chunks, attachments and metadata, in the order of the
        file.
    """

    def __init__(self) -> None:
        self.records: list[records.McapRecord] = []

    def add(self, record: object, start: int, end: int) -> None:
        """Add a record of the data section, which is in the bytes `start` to `end` of the file.

        Message indexes follow their chunk.
        """
        match record:
            case records.Schema() | records.Channel():
                self.records.append(record)
            case records.Metadata():
                self.records.append(records.MetadataIndex(start, end - start, record.name))
            case records.Attachment(name=name, media_type=media_type, data=data):
                about = record.log_time, record.create_time, len(data), name, media_type
                self.records.append(records.AttachmentIndex(start, end - start, *about))
            case records.Chunk():
                self.records.append(
                    records.ChunkIndex(
                        chunk_length=end - start,
                        chunk_start_offset=start,
                        compression=record.compression,
                        compressed_size=len(record.data),
                        message_end_time=record.message_end_time,
                        message_index_length=0,
                        message_index_offsets={},
                        message_start_time=record.message_start_time,
                        uncompressed_size=record.uncompressed_size,
                    )
                )
            case MessageIndex() if self.records and isinstance(
                chunk := self.records[-1], records.ChunkIndex
            ):
                chunk.message_index_offsets[record.channel] = start
                chunk.message_index_length += end - start

    def statistics(
        self, counts: Mapping[int, int], first_ns: int, last_ns: int
    ) -> records.Statistics:
        """Return the statistics of a file with `counts` messages in each channel."""
        kinds = Counter(type(record) for record in self.records)
        return records.Statistics(
            attachment_count=kinds[records.AttachmentIndex],
            channel_count=kinds[records.Channel],
            channel_message_counts=dict(sorted(counts.items())),
            chunk_count=kinds[records.ChunkIndex],
            message_count=sum(counts.values()),
            metadata_count=kinds[records.MetadataIndex],
            message_start_time=first_ns,
            message_end_time=last_ns,
            schema_count=kinds[records.Schema],
        )
