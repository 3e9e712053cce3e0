"""The summary of an MCAP file: what it holds, and where."""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import BinaryIO

from mcap import records
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from slipmode.runner.recording.mcapfile.layout import record_bytes
from slipmode.runner.recording.mcapfile.scan import DamagedError, scan

_CRC = struct.Struct("<I")


@dataclass
class Summary:
    """What a file holds, gathered while it is written."""

    schemas: list[records.Schema] = field(default_factory=list)
    channels: list[records.Channel] = field(default_factory=list)
    chunks: list[records.ChunkIndex] = field(default_factory=list)
    attachments: list[records.AttachmentIndex] = field(default_factory=list)
    metadata: list[records.MetadataIndex] = field(default_factory=list)
    counts: Counter[int] = field(default_factory=Counter)

    def to_bytes(self, start: int) -> bytes:
        """The summary section with its footer, for a file where it begins at offset `start`."""
        groups: dict[Opcode, Sequence[records.McapRecord]] = {
            Opcode.SCHEMA: self.schemas,
            Opcode.CHANNEL: self.channels,
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: self.chunks,
            Opcode.ATTACHMENT_INDEX: self.attachments,
            Opcode.METADATA_INDEX: self.metadata,
        }
        section = offsets = b""
        for opcode, members in groups.items():
            group = b"".join(map(record_bytes, members))
            if group:
                place = records.SummaryOffset(opcode, start + len(section), len(group))
                offsets += record_bytes(place)
            section += group
        footer = records.Footer(start, start + len(section), 0)
        checked = section + offsets + record_bytes(footer)[: -_CRC.size]
        return checked + _CRC.pack(zlib.crc32(checked))

    def _statistics(self) -> records.Statistics:
        return records.Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(sorted(self.counts.items())),
            chunk_count=len(self.chunks),
            message_count=self.counts.total(),
            metadata_count=len(self.metadata),
            message_start_time=min((c.message_start_time for c in self.chunks), default=0),
            message_end_time=max((c.message_end_time for c in self.chunks), default=0),
            schema_count=len(self.schemas),
        )


def read_summary(file: BinaryIO) -> list[records.McapRecord]:
    """Records of the summary of a file, none if it has none or the summary is damaged."""
    size = file.seek(0, os.SEEK_END)
    tail = record_bytes(records.Footer(0, 0, 0)) + MCAP0_MAGIC
    if size < len(MCAP0_MAGIC) + len(tail):
        return []
    file.seek(size - len(tail))
    found = []
    try:
        (footer,) = (piece.record for piece in scan(file))
        if not isinstance(footer, records.Footer) or not footer.summary_start:
            return []
        file.seek(footer.summary_start)
        checked = file.read(size - len(MCAP0_MAGIC) - _CRC.size - footer.summary_start)
        if footer.summary_crc not in (0, zlib.crc32(checked)):
            return []
        file.seek(footer.summary_start)
        found = [piece.record for piece in scan(file)]
    except (DamagedError, ValueError, OverflowError):
        return []
    return [record for record in found if isinstance(record, records.McapRecord)]
