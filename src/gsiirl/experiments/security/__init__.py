"""The security experiment: a defender of an attack graph and an attacker."""
