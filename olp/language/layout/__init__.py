"""How a text is laid out: one file per vendor, with one subclass of `Layout`; its name is the vendor's."""
