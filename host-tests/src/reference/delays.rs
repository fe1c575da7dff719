//! What of the class offsets is a delay, which in angle grows with speed.

use super::plan::Plan;
use super::turns::Turn;

/// Angles that the classes' delays make at the first turn's speed, turns, zero mean; none where speeds are too alike to tell,
/// or where no delay stands out of its noise.
pub(super) fn delays(turns: &[Turn], plan: Plan) -> Option<Vec<f64>> {
    let count = turns.len() as f64;
    let square: f64 = turns.iter().map(|turn| turn.ratio.powi(2)).sum();
    let duration: f64 = turns.iter().map(|turn| turn.ratio).sum();
    let determinant = square * count - duration * duration;
    if plan.classes < 2 || determinant * 100.0 <= square * count {
        return None;
    }
    // Mean step into each class by c + d / ratio, weighed with ratio^2.
    let (mut slopes, mut residual) = (Vec::new(), 0.0);
    for class in 0..plan.classes {
        let points: Vec<(f64, f64)> = turns
            .iter()
            .map(|turn| (turn.ratio, mean_step(turn, class, plan.classes)))
            .collect();
        let by_square: f64 = points.iter().map(|(ratio, x)| ratio * ratio * x).sum();
        let by_duration: f64 = points.iter().map(|(ratio, x)| ratio * x).sum();
        let slope = (square * by_duration - duration * by_square) / determinant;
        let level = (count * by_square - duration * by_duration) / determinant;
        let off = |(ratio, x): &(f64, f64)| (ratio * (x - level) - slope).powi(2);
        residual += points.iter().map(off).sum::<f64>();
        slopes.push(slope);
    }
    let freedom = (count - 2.0).max(1.0) * plan.classes as f64;
    let standard_error = (residual / freedom * square / determinant).sqrt();
    // A step is short by what the error grows.
    let mean = slopes.iter().sum::<f64>() / plan.classes as f64;
    let mut angles = vec![0.0];
    for slope in &slopes[1..] {
        angles.push(angles[angles.len() - 1] - (slope - mean));
    }
    let middle = angles.iter().sum::<f64>() / plan.classes as f64;
    angles.iter_mut().for_each(|angle| *angle -= middle);
    let largest = angles
        .iter()
        .fold(0.0, |largest: f64, angle| largest.max(angle.abs()));
    (largest > 5.0 * standard_error).then_some(angles)
}

/// Mean deviation of the steps into the edges of a class.
fn mean_step(turn: &Turn, class: usize, classes: usize) -> f64 {
    let edges = turn.error.len();
    let into = |k: usize| turn.error[(k + edges - 1) % edges] - turn.error[k];
    (class..edges).step_by(classes).map(into).sum::<f64>() * classes as f64 / edges as f64
}
