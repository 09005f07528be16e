"""What all pages share: rendering, assets, errors, and how values and verdicts are shown."""
