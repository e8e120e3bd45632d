"""Three versions of one program become one: what two people did to it at the same time."""
