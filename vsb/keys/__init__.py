"""Keys of the files a person writes: their numbers, units and meaning, how they are read, how mistakes are reported."""
