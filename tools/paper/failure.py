"""What an operator can mend."""


class Failure(Exception):
    """One line: what failed, the value, and what was expected."""
