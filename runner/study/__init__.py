"""Studies: a scene many times, with other values, on all cores or a cluster: `slipmode study`.

study.py            a study from its file to its results. Start here
study_file.py       reading the file; scene_keys.py: the keys of scenes that it names
design.py           the values of every sample
scene_model.py      samples as scenes, and what they share: a plan, and friction tables
shared_limits.py    scenes that differ in their limits alone share a friction table
sample_outputs.py   the requested outputs, and the arrays that hold them
compute.py          the outputs of a batch of samples; mistuned_samples.py: of mistuned disks
workers/            batches of samples by model, and the processes that compute them
results.py          the results on disk
summary/            the best value of a key, sensitivities, a picture
"""
