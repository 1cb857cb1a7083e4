"""What a client can meet beside wrong arguments."""


class Refused(RuntimeError):
    """A process has answered that it does not do what it was asked; the text says why."""


class WrongClock(RuntimeError):
    """The run is in lockstep and this process in realtime, or the other way round."""


class NoAnswer(TimeoutError):
    """Nobody has answered, or nothing has come, for as long as was given."""
