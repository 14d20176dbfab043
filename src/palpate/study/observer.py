"""Who watches a study: the study tells, a door draws bars or prints lines."""

from __future__ import annotations

from abc import ABC, abstractmethod


class Observer(ABC):
    """Called as a study goes; costs are expected seconds on one core, for bars and remaining time."""

    @abstractmethod
    def planned(self, tasks: int, reused: int, cost: float) -> None:
        """Say that `tasks` tasks of `cost` seconds are to be done and `reused` artefacts were found."""

    @abstractmethod
    def started(self, task: str) -> None:
        """Say that a task was given to a worker."""

    @abstractmethod
    def ended(self, task: str, cost: float, seconds: float, reason: str) -> None:
        """Say that a task ended after `seconds`; `reason` is empty, or why it gave nothing."""

    @abstractmethod
    def message(self, sentence: str) -> None:
        """Say how far it has come: a sentence for a person."""


class NullObserver(Observer):
    """Watches without a word."""

    def planned(self, tasks: int, reused: int, cost: float) -> None:
        pass

    def started(self, task: str) -> None:
        pass

    def ended(self, task: str, cost: float, seconds: float, reason: str) -> None:
        pass

    def message(self, sentence: str) -> None:
        pass
