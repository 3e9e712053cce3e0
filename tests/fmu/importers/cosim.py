"""`python cosim.py FMU STEPS NAME...`: values after steps of 1 s in libcosim, in hexadecimal."""

import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

path, steps, *names = sys.argv[1:]
log_output_level(CosimLogLevel.FATAL)
execution = CosimExecution.from_step_size(1_000_000_000)  # [ns]
ours = execution.add_local_slave(CosimLocalSlave(path, "ours"))
assert ours >= 0, "libcosim does not load the FMU"
references = {v.name.decode(): v.reference for v in execution.slave_variables(ours)}
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(int(steps))
values = observer.last_real_values(ours, [references[name] for name in names])
print(*(float(value).hex() for value in values))
