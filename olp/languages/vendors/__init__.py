"""Robot makers' languages: one package each. The folder listing is the registry, see `olp.languages.vendor`."""
