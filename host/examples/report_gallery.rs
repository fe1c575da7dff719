//! Writes a report with every kind of figure, filled with made-up data of an encoder calibration:
//! `cargo run -p quadcal-host --example report_gallery -- gallery.html`.

use std::f64::consts::TAU;
use std::path::Path;

use quadcal_host::report::plot::{Axis, Band, Bars, Histogram, Polar, Series, Spectrum, Strip, Xy};
use quadcal_host::report::{Body, Cell, Colour, Footer, InputFile, Level, Report, Tile};

const LINES: usize = 2500;
const EDGES: usize = 4 * LINES;
/// 15 r/min in rad/s.
const SPEED: f64 = TAU / 4.0;
const TURNS: usize = 11;

/// A small reproducible generator; uniform on -1..1.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn normal(&mut self) -> f64 {
        (0..6).map(|_| self.uniform()).sum::<f64>() / 2f64.sqrt()
    }
}

/// Error of each edge before and after, in rad.
fn errors(noise: &mut Noise) -> (Vec<f64>, Vec<f64>) {
    let mut before = Vec::new();
    let mut after = Vec::new();
    for k in 0..EDGES {
        let angle = TAU * k as f64 / EDGES as f64;
        let class = [0.0, 1.26e-4, 1.26e-4, 2.4e-4][k % 4] - 1.2e-4;
        let dirt = 3e-4 * (-((angle - 3.9) / 0.01).powi(2)).exp();
        let slow =
            4e-5 * (angle + 0.4).cos() + 2.2e-5 * (2.0 * angle).cos() + 1e-5 * (5.0 * angle).sin();
        before.push(class + dirt + slow + 6.28e-5 * noise.uniform());
        after.push(1.4e-6 * noise.normal() + 0.6e-6 * (angle * 3.0).sin());
    }
    (before, after)
}

/// Amplitude at orders 1 to `EDGES / 2`, made up to suit `errors`.
fn spectrum(noise: &mut Noise, before: bool) -> (Vec<f64>, Vec<f64>) {
    let level = if before { 7e-7 } else { 1.5e-8 };
    let lines: &[(usize, f64)] = if before {
        &[
            (1, 4e-5),
            (2, 2.2e-5),
            (5, 1e-5),
            (10, 4e-6),
            (15, 2e-6),
            (LINES, 6e-5),
        ]
    } else {
        &[(3, 4e-7), (5, 2e-7), (LINES, 9e-8)]
    };
    let orders = 1..=EDGES / 2;
    let amplitude = |order: usize, noise: &mut Noise| {
        let line = lines.iter().find(|l| l.0 == order).map_or(0.0, |l| l.1);
        line + level * noise.normal().hypot(noise.normal())
    };
    orders.map(|o| (o as f64, amplitude(o, noise))).unzip()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

fn main() -> std::io::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "report-gallery.html".to_owned());
    let mut noise = Noise(0x2545_F491_4F6C_DD1D);
    let (before, after) = errors(&mut noise);
    let degrees: Vec<f64> = (0..EDGES)
        .map(|k| 360.0 * k as f64 / EDGES as f64)
        .collect();
    let speed = |error: &[f64], noise: &mut Noise| -> Vec<f64> {
        let ripple = |k: usize| 2e-3 * (5.0 * TAU * k as f64 / EDGES as f64).sin();
        let step = TAU / EDGES as f64;
        (0..EDGES)
            .map(|k| {
                (SPEED + ripple(k)) * step
                    / (step - (error[(k + 1) % EDGES] - error[k]) + 2e-8 * noise.normal())
            })
            .collect()
    };
    let (raw_speed, speed_after) = (speed(&before, &mut noise), speed(&after, &mut noise));

    let mut report = Report::new(
        "Encoder calibration",
        "paper-rig.toml: 2500 lines, 15 r/min, 84 MHz clock, 11 turns",
    );
    let gain = 100.0 * (1.0 - rms(&after) / rms(&before));
    report.verdict(
        Level::Good,
        format!("The angle error is down by {gain:.1}\u{a0}%: the table may be used."),
        vec![
            Tile::si(
                "Error before",
                rms(&before),
                "rad",
                "RMS over 5 turns not used to calibrate",
            ),
            Tile::si("Error after", rms(&after), "rad", "RMS, same turns"),
            Tile::new(
                "Reduction",
                format!("{gain:.1}"),
                "%",
                "95 % interval 98.4 to 98.6 %",
            ),
            Tile::new("Faults", "0", "", "lost, extra or illegal edges"),
        ],
    );
    report.section(
        "Angle error",
        &["What is left of each edge's position error once the table is applied, against the true edge angles of the simulation."],
    );
    report.figure(
        Xy::new(Axis::turn(), Axis::new("Angle error", "rad"))
            .series(Series::line("before", &degrees, &before).colour(Colour::BEFORE))
            .series(Series::line("after", &degrees, &after).colour(Colour::AFTER))
            .mark_x(223.5, "local defect"),
        "Angle error of every edge over one turn, mean of 11 turns.",
    );
    let (orders, raw) = spectrum(&mut noise, true);
    let (_, rest) = spectrum(&mut noise, false);
    let level = vec![1.9e-8; orders.len()];
    let (lo, hi): (Vec<f64>, Vec<f64>) = level.iter().map(|v| (v * 0.2, v * 2.4)).unzip();
    report.figure(
        Spectrum::new("rad")
            .stems("before", &orders, &raw, Colour::BEFORE)
            .stems("after", &orders, &rest, Colour::AFTER)
            .floor("noise floor", &[1.0], &[1.9e-8])
            .band("95 % of the noise", &orders, &lo, &hi)
            .name(1.0, "1 eccentricity")
            .name(2.0, "2 tilt")
            .name(5.0, "5 pole pairs")
            .name(10.0, "10")
            .name(15.0, "15")
            .name(LINES as f64, "2500 width, quadrature"),
        "Order spectrum of the angle error. Orders under the noise floor are left alone.",
    );
    report.section(
        "Speed",
        &["Instantaneous angular speed by the T-method, as measured and after correction."],
    );
    report.figure(
        Xy::new(Axis::turn(), Axis::new("Angular speed", "rad/s"))
            .series(Series::line("before", &degrees, &raw_speed).colour(Colour::BEFORE))
            .series(Series::line("after", &degrees, &speed_after).colour(Colour::AFTER)),
        "Speed over one turn: the scatter is the encoder's, the slow wave the motor's torque ripple.",
    );
    let coarse: Vec<f64> = (0..73).map(|i| f64::from(i) * 5.0).collect();
    let truth: Vec<f64> = coarse
        .iter()
        .map(|a| SPEED + 2e-3 * (5.0 * a.to_radians()).sin())
        .collect();
    let found: Vec<f64> = truth.iter().map(|v| v + 1.5e-4 * noise.normal()).collect();
    let (low, high): (Vec<f64>, Vec<f64>) = found.iter().map(|v| (v - 3e-4, v + 3e-4)).unzip();
    report.figure_pair(
        (
            Xy::new(Axis::turn(), Axis::new("Angular speed", "rad/s"))
                .band(Band::new("95 % band", &coarse, &low, &high, Colour::AFTER))
                .series(Series::dashed("truth", &coarse, &truth).colour(Colour::TRUTH))
                .series(Series::points("corrected", &coarse, &found).colour(Colour::AFTER)),
            "Corrected speed every 5 degrees with its confidence band.",
        ),
        (
            Histogram::new(Axis::new("Interval error", "s").range(-4e-6, 4e-6))
                .values(
                    "before",
                    &before.iter().map(|e| e * 1e-2).collect::<Vec<_>>(),
                    Colour::BEFORE,
                )
                .values(
                    "after",
                    &after.iter().map(|e| e * 3e-1).collect::<Vec<_>>(),
                    Colour::AFTER,
                ),
            "Distribution of the interval error.",
        ),
    );
    report.section(
        "Estimates",
        &["Width and quadrature errors beside the paper's table 1, in unique form."],
    );
    let row = |name: &str, truth: f64, paper: f64, ours: f64, error: f64| -> Vec<Cell> {
        let off = |v: f64| Cell::fixed(100.0 * (v / truth - 1.0), 2);
        vec![
            name.into(),
            Cell::si_digits(truth, "rad", 5),
            Cell::si_digits(paper, "rad", 5),
            off(paper),
            Cell::with_error(ours, error, "rad"),
            off(ours),
        ]
    };
    report.table(
        "Table 1 of the paper beside ours",
        &[
            "Parameter",
            "True",
            "Paper",
            "off by, %",
            "Ours ± standard error",
            "off by, %",
        ],
        vec![
            row("Width error A", 1.2566e-4, 1.3334e-4, 1.25663e-4, 3.1e-8),
            row("Width error B", 1.1310e-4, 1.2001e-4, 1.13092e-4, 3.2e-8),
            row("Quadrature error", 1.2566e-4, 1.3320e-4, 1.25648e-4, 3.1e-8),
        ],
    );
    let wide = |e: &[f64]| -> (Vec<f64>, Vec<f64>) {
        (0..EDGES)
            .step_by(4)
            .map(|k| {
                (
                    degrees[k],
                    e[k] + 1.2e-4 * f64::from(u8::from(e[k].abs() > 1e-5)),
                )
            })
            .unzip()
    };
    let ((angles, class_before), (_, class_after)) = (wide(&before), wide(&after));
    report.figure(
        Bars::new(Axis::new("Angle error, RMS", "rad").log())
            .bar("raw", rms(&before), Colour::BEFORE)
            .bar("paper, as printed", 2.1e-2, Colour::Grey)
            .bar("paper, closed over a turn", 3.1e-4, Colour::Grey)
            .bar("ours", rms(&after), Colour::AFTER),
        "RMS error of each method on the same 11 turns.",
    );
    let round = |name: &str, values: &[f64], colour| {
        Polar::new(Axis::new("Angle error", "rad")).series(name, &angles, values, colour)
    };
    report.figure_pair(
        (
            round("before", &class_before, Colour::BEFORE),
            "Line position error around the disc, radially exaggerated; the solid circle is zero.",
        ),
        (
            round("after", &class_after, Colour::AFTER),
            "The same after correction; mind the finer scale.",
        ),
    );
    report.section(
        "Repeatability",
        &["A pattern that repeats from turn to turn can be learned; what does not is noise."],
    );
    let strip = (0..TURNS).fold(Strip::new("Angle error", "rad"), |strip, turn| {
        let values: Vec<f64> = (0..EDGES)
            .map(|k| {
                class_before.get(k / 4).copied().unwrap_or(0.0) * 0.4
                    + 1e-5 * noise.normal()
                    + 4e-6 * turn as f64
            })
            .collect();
        strip.turn(&values)
    });
    report.figure(
        strip,
        "Angle error by shaft angle and turn; turn 1 is at the foot.",
    );
    let mut inner = Body::new();
    inner.section("", &["Window 31, polynomial degree 5; 11 turns; orders above 2400 are taken from the class means alone."]);
    inner.table(
        "Setting of the calibration",
        &["Setting", "Value"],
        vec![
            vec!["Turns used".into(), 6.0.into()],
            vec!["Turns held back".into(), 5.0.into()],
            vec!["Clock".into(), Cell::si(84e6, "Hz")],
        ],
    );
    report.details("How it was computed", inner);
    report.footer(Footer {
        version: "quadcal 0.1.0".into(),
        command: "quadcal calibrate paper-rig.csv --twin paper-rig.toml -o paper-rig.qct".into(),
        inputs: vec![InputFile {
            name: "paper-rig.csv".into(),
            bytes: 1_843_200,
            sha256: "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08".into(),
        }],
    });
    report.write(Path::new(&path))
}
