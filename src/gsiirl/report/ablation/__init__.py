"""The page of `gsiirl ablation`: what each change brought."""
