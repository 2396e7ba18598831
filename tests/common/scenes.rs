//! A room of 4 x 5 x 3 m as a scene file, in parts to be put together, each a table or more.

/// The format, a grey material and the room; comes first.
pub const ROOM: &str = r#"format = 1
[materials.grey.lambert]
reflectance = 0.6
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "grey"
"#;

/// A ball in its middle.
pub const BALL: &str = r#"[objects.ball.sphere]
centre = [2, 3, 1]
radius = 0.7
material = "grey"
"#;

/// A lamp over a corner.
pub const LAMP: &str = "[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
";

/// A camera that sees the ball; its resolution must follow.
pub const CAMERA: &str = "[cameras.main.perspective]
from = [2, 0.3, 1.5]
to = [2, 3, 1]
fov = 60
";
