"""Writing the .fmu file.

export.py           export: a model as a zip archive. Start here.
resources.py        resources/*.npy, which fmu/src/resources/model.c reads
binaries.py         the host's library and the C sources; cross_compiler.py: other platforms
"""
