"""The summary of an MCAP file: what it holds, and where."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from mcap import records
from mcap.opcode import Opcode

from runner.mcapfile.layout import record_bytes


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
        checked = section + offsets + record_bytes(footer)[: -struct.calcsize("<I")]
        return checked + struct.pack("<I", zlib.crc32(checked))

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
