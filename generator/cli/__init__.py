"""The command ``ccgen``, one file per command. What a command needs is imported when it runs: it starts fast."""


def main() -> None:
    """Entry point of ``ccgen``."""
    from .app import app

    app(prog_name="ccgen")
