//! What needs several rooms: fitting a mesh, loading a scene, sweeping truncation degrees, checking
//! an intersector.

mod batch;
mod built;
mod compare;
mod detail;
mod grids;
mod known;
mod load;
mod on_surface;
#[cfg(feature = "plots")]
mod page;
mod pictures;
mod requirements;
mod sensors;
mod settings;
mod shared_surfaces;
mod solids;
mod stage;
mod sweep;
mod view;
mod warnings;

pub use batch::batch;
pub use compare::{
    CompareSettings, Comparison, DistanceMap, FarthestPoint, Hausdorff, Limit, NormalAngles, Pair,
    RadialDifference, Subject, compare,
};
pub use detail::{Detail, detail};
pub use known::known_illuminance;
pub use load::{DetailedObject, FittedObject, Loaded, camera, load, load_for_camera};
#[cfg(feature = "plots")]
pub use page::Page;
use pictures::relative_mse;
pub use pictures::{
    FALSE_ALARMS, FEWEST_REPLICATES, Flip, JointLevel, JointTest, PIXELS_PER_DEGREE, Picture,
    PictureComparison, PictureMap, RelativeMse, compare_pictures, flip, flip_ldr, joint_test,
};
pub use requirements::{Judged, Verdict, judge};
pub use sensors::SensorGroup;
pub use settings::{image_settings, sensor_settings};
pub use shared_surfaces::Preparation;
pub use stage::{LoadingObserver, LoadingStage};
pub use sweep::{
    Column, Light, LightSettings, Original, Rendition, Rivals, Sweep, SweepLimit, SweepRow,
};
#[cfg(feature = "plots")]
pub use sweep::{SWEEP_FIGURES, sweep_figures};
pub use view::check_view;
