"""Start the sensor: `ros2 launch palpate_ros sensor.launch.py twin:=/path/twin.h5 source:=0`.

It stays unconfigured; `ros2 lifecycle set /palpate configure` opens it, the dome untouched, and `activate` publishes.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description() -> LaunchDescription:
    """The node with its file of parameters, of which twin and source are arguments."""
    file = Path(get_package_share_directory("palpate_ros")) / "config" / "sensor.yaml"
    said = {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in ("twin", "source")}
    return LaunchDescription(
        [
            DeclareLaunchArgument("twin", description="file of the design's twin"),
            DeclareLaunchArgument("source", default_value="0", description="number of a camera, or a path"),
            LifecycleNode(
                package="palpate_ros",
                executable="sensor",
                name="palpate",
                namespace="",
                parameters=[str(file), said],
                output="screen",
            ),
        ]
    )
