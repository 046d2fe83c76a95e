"""Many runs as one plan: the paper's comparison and the ablation."""
