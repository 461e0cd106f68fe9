"""Tools that know nothing of the physics: files, stamps, variables of files, units of ports, words."""
