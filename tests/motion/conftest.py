"""Prediction models that the tests of this folder share."""

from physics_fixtures import make_model
import pytest


@pytest.fixture(scope="session")
def models():
    """Prediction models by the names of their objects, made when used."""
    made = {}

    def get(*names: str):
        if names not in made:
            made[names] = make_model(*names)
        return made[names]

    return get


@pytest.fixture(scope="session")
def block(models):
    return models("block")


@pytest.fixture(scope="session")
def two(models):
    return models("block", "soup")
