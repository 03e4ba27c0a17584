"""What the tests share."""

import os
import socket
from pathlib import Path

import pytest

SHIPPED = Path(__file__).resolve().parents[2]


@pytest.fixture
def shipped() -> Path:
    """The folder of the scenarios, with the cams and saws that come with it."""
    return SHIPPED


@pytest.fixture
def endpoint() -> str:
    """Where nobody listens yet."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{free.getsockname()[1]}"


@pytest.fixture
def tool() -> str:
    """The tool of the same build, where COAXLE_TOOL says which."""
    path = os.environ.get("COAXLE_TOOL")
    if path is None:
        pytest.skip("COAXLE_TOOL says no tool")
    return path
