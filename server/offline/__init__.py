"""The module as one archive that opens without a server: its texts, figures and replays."""
