"""Build of the ament_python package; palpate itself is installed by pip."""

from setuptools import setup

NAME = "palpate_ros"
setup(
    name=NAME,
    version="0.2.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/sensor.launch.py"]),
        (f"share/{NAME}/config", ["config/sensor.yaml"]),
    ],
    install_requires=["setuptools", "palpate[vision]"],
    license="Apache-2.0",
    entry_points={"console_scripts": [f"sensor = {NAME}.node:main"]},
)
