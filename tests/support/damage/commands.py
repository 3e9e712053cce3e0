"""The commands for recordings, with the options that say where they write."""

COMMANDS = {
    "info": (),
    "doctor": (),
    "recover": ("-o", "out.mcap"),
    "export": ("-o", "out.npz"),
    "replay": ("--save", "out.rrd"),
}
