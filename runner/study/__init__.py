"""Studies: a scene many times, with other values, on all cores or a cluster: `slipmode study`.

study.py           a study from its file to its results. Start here; command.py: the command line
study_file.py      reading the file; scene_keys.py: the keys of scenes that it names
design.py          the values of every sample
scene_model.py     samples as scenes, and what they share: a plan, and friction tables
shared_limits.py   scenes that differ in their limits alone share a friction table
outputs/           what is computed of each sample
tasks.py           samples in batches, by model
foreman.py         handing batches out to cluster.py, the processes that work on them
results.py         the results on disk
summary/           the best value of a key, sensitivities, a picture
"""
