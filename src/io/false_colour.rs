//! False colours: numbers as colours that grow lighter evenly.

/// Gives the colour of the viridis scale (van der Walt and Smith, 2015), 0 to 255, for a share from 0 (dark violet) to 1 (yellow); what is beyond is held to the ends, and what is not a number is the lower end.
///
/// ```
/// use harmolux::io::false_colour::viridis;
/// assert_eq!((viridis(0.0), viridis(2.0)), ([68, 1, 84], [253, 231, 37]));
/// ```
pub fn viridis(share: f64) -> [u8; 3] {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let colour = colorous::VIRIDIS.eval_continuous(share);
    [colour.r, colour.g, colour.b]
}
