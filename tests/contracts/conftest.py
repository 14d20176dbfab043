"""The guest package's tests run where it is installed, by `test_outside_package.py`."""

collect_ignore = ["outside_package"]
