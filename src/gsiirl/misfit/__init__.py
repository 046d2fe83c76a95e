"""Does the model of the expert fit what it was seen to do? Other models, and a check that names the better one."""
