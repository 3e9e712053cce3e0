"""Studies: a scene many times, with other values, on all cores or a cluster: `slipmode study`.

study.py           a study from its file to its results. Start here; command.py: the command line
study_file.py      reading the file; scene_keys.py: the keys of scenes that it names
design.py          the values of every sample
shared_limits.py   scenes that differ in their limits alone share a friction table
scene_model.py     what samples share: the plan of their scene, and tables as wide as they need
outputs/           what is computed of a sample
tasks.py           samples in batches, by model; cluster.py: the processes that work on them
results.py         what was computed, on disk
summary/           the best value of a key, sensitivities, a picture
"""
