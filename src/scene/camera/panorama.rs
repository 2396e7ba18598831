//! The panorama: all around and from pole to pole, columns being equal steps of azimuth and rows of
//! the angle from above (equirectangular).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// Returns the direction of a film position. Beyond the left and right borders the picture goes on
/// on the other side, beyond the upper and lower ones over the pole.
pub(super) fn direction(film: DVec2, size: DVec2) -> DVec3 {
    let (sine, cosine) = (PI * film.y / size.y).sin_cos();
    let azimuth = TAU * (film.x / size.x - 0.5);
    DVec3::new(sine * azimuth.sin(), -cosine, sine * azimuth.cos())
}

/// Returns where a direction is on the film, and there the pixels^2 per steradian; `None` at the
/// poles, which are whole rows.
pub(super) fn film(direction: DVec3, size: DVec2) -> Option<(DVec2, f64)> {
    let sine = direction.x.hypot(direction.z);
    let azimuth = direction.x.atan2(direction.z);
    let at = DVec2::new(azimuth / TAU + 0.5, sine.atan2(-direction.y) / PI);
    (sine > 0.0).then(|| (at * size, size.x * size.y / (TAU * PI * sine)))
}

/// Returns the film positions at most `margin` pixels outside the picture that show the same as
/// `film`.
pub(super) fn repeats(film: DVec2, margin: f64, size: DVec2) -> impl Iterator<Item = DVec2> {
    let around = DVec2::new(size.x, 0.0);
    let over = |x: f64, y: f64| DVec2::new(film.x + x * size.x, y - film.y);
    let all = [
        film,
        film + around,
        film - around,
        over(0.5, 0.0),
        over(-0.5, 0.0),
        over(0.5, 2.0 * size.y),
        over(-0.5, 2.0 * size.y),
    ];
    let within = move |at: &DVec2| {
        at.cmpge(DVec2::splat(-margin)).all() && at.cmple(size + DVec2::splat(margin)).all()
    };
    all.into_iter().filter(within)
}

/// Bounds the movement in the picture, pixels, of what turns by `turn` and is between the angles
/// `angles` from above.
pub(super) fn movement(angles: [f64; 2], turn: f64, size: DVec2) -> f64 {
    let [low, high] = [angles[0] - turn, angles[1] + turn];
    if low <= 0.0 || high >= PI {
        return f64::INFINITY;
    }
    let across = size.x / (TAU * low.sin().min(high.sin()));
    turn * across.max(size.y / PI)
}
