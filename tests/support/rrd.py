"""Recordings of Rerun, asked by its own command."""

import shutil
import subprocess
import sysconfig

RERUN = shutil.which("rerun", path=sysconfig.get_path("scripts"))


def verified(path):
    done = subprocess.run([RERUN, "rrd", "verify", path], capture_output=True, text=True)
    return done.returncode == 0
