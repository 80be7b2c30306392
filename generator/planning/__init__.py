"""Which unknown goes when: the order of elimination as a record, and its choice for a mechanism."""
