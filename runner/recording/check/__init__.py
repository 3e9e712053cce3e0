"""Whether a recording is sound: info, doctor, recover."""
