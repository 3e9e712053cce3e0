"""What an FMU says of itself.

xml_writer.py       modelDescription.xml: what FMI 2.0 and 3.0 write alike. Start here.
fmi2.py, fmi3.py    where they differ; description.py: what is said whatever the version
terminals.py        terminalsAndIcons.xml of FMI 3.0
documentation.py, reference_result.py   documentation/ and extra/ of the archive
"""
