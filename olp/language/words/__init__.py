"""How each language spells its names: one file per vendor, with one subclass of `Words`; its name is the vendor's."""
