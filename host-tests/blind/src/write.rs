//! Files of a case: recordings, twins, the known errors, and the sealed truth.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::capture::Row;
use crate::encoder::Encoder;
use crate::rig::{Profile, Rig, Told};

const R_MIN: f64 = 60.0 / std::f64::consts::TAU;

/// A recording in the native format: nothing in it tells what was drawn.
#[must_use]
pub fn recording(rig: &Rig, rows: &[Row]) -> String {
    let (count, columns, bits): (_, _, &[u8]) = match rig.encoder {
        Encoder::Quadrature { lines, index: true } => (("lines", lines), "a,b,z", &[1, 2, 8]),
        Encoder::Quadrature { lines, .. } => (("lines", lines), "a,b", &[1, 2]),
        Encoder::Hall { pole_pairs } => (("pole_pairs", pole_pairs), "a,b,c", &[1, 2, 4]),
        Encoder::Wheel { teeth } => (("teeth", teeth), "a", &[1]),
    };
    let mut text = format!(
        "# clock_hz = {}\n# {} = {}\nticks,{columns}\n",
        rig.clock_hz, count.0, count.1
    );
    for &(ticks, levels) in rows {
        let _ = write!(text, "{ticks}");
        for bit in bits {
            text.push_str(if levels & bit == 0 { ",0" } else { ",1" });
        }
        text.push('\n');
    }
    text
}

/// The twin of a rig, without the effects; the known errors stand in `errors.csv` beside it.
#[must_use]
pub fn twin(rig: &Rig) -> String {
    let mut text = format!("duration = {{ turns = {:?} }}\n", rig.turns);
    let mut line = |more: String| {
        text.push_str(&more);
        text.push('\n');
    };
    match rig.encoder {
        Encoder::Quadrature { lines, index } => line(format!(
            "\n[encoder.quadrature]\nlines = {lines}\nindex = {index}"
        )),
        Encoder::Hall { pole_pairs } => {
            line(format!("\n[encoder.hall]\npole_pairs = {pole_pairs}"));
        }
        Encoder::Wheel { teeth } => line(format!("\n[encoder.wheel]\nteeth = {teeth}")),
    }
    if rig.disc_known {
        line("\n[errors]\ncsv = \"errors.csv\"".to_owned());
    }
    line(shaft(rig));
    if !rig.encoder.index() && rig.told != Told::InertiaOnly {
        line(format!("initial_angle_rad = {:e}", rig.start_rad));
    }
    if rig.told == Told::Whole {
        line(drive(&rig.profile));
    }
    if rig.told != Told::InertiaOnly {
        for ripple in &rig.ripples {
            line(format!(
                "\n[[ripple]]\norder = {:?}\nphase_rad = {:e}\ntorque_n_m = {:e}",
                ripple.order, ripple.phase_rad, ripple.torque_n_m
            ));
        }
    }
    if rig.noise_known && rig.noise_psd > 0.0 {
        line(format!(
            "\n[noise.white]\npsd_n2_m2_s = {:e}",
            rig.noise_psd
        ));
    }
    line(format!("\n[timer]\nclock_hz = {}", rig.clock_hz));
    if rig.noise_known && rig.jitter_s > 0.0 {
        line(format!("jitter_s = {:e}", rig.jitter_s));
    }
    text
}

/// What the twin gives of the shaft.
fn shaft(rig: &Rig) -> String {
    let inertia = format!("\n[shaft]\ninertia_kg_m2 = {:e}", rig.inertia);
    let friction = format!(
        "\nviscous_n_m_s = {:e}\ncoulomb_n_m = {:e}",
        rig.viscous, rig.coulomb
    );
    match rig.told {
        Told::InertiaOnly => inertia,
        Told::NoDrive => inertia + &friction,
        // How stiffly a drive pulls is the drive's.
        Told::Whole => inertia + &friction + &format!("\nstiffness_n_m_s = {:e}", rig.stiffness),
    }
}

/// What the drive asks for; nothing where the twin has no word for it.
fn drive(profile: &Profile) -> String {
    match *profile {
        Profile::Constant { speed } => format!("\n[drive.constant]\nr_min = {:?}", speed * R_MIN),
        Profile::Ramp { from, to, over_s } => format!(
            "\n[drive.ramp]\nfrom_r_min = {:?}\nto_r_min = {:?}\nover_s = {over_s:?}",
            from * R_MIN,
            to * R_MIN
        ),
        Profile::RunDown { speed, off_s } => format!(
            "\n[drive.run_down]\nr_min = {:?}\noff_s = {off_s:?}",
            speed * R_MIN
        ),
        Profile::Loop {
            speed,
            f_hz,
            kp_n_m_s,
            ki_n_m,
        } => format!(
            "\n[drive.speed_loop]\nr_min = {:?}\nf_hz = {f_hz:?}\nkp_n_m_s = {kp_n_m_s:e}\nki_n_m = {ki_n_m:e}",
            speed * R_MIN
        ),
        Profile::Free(_) => String::new(),
    }
}

/// The known errors as a twin reads them.
#[must_use]
pub fn errors(rig: &Rig) -> String {
    let mut text = String::from("k,e_rad\n");
    for (k, e) in rig.disc_rad.iter().enumerate() {
        let _ = writeln!(text, "{k},{e:e}");
    }
    text
}

/// Writes the open folder of a case: a recording and a twin for each run.
///
/// # Errors
/// If a file cannot be written.
pub fn open_folder(folder: &Path, runs: &[(Rig, Vec<Row>)]) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (number, (rig, rows)) in runs.iter().enumerate() {
        // One rig has one twin; that of another speed differs in drive and duration only.
        let (rec, toml) = match (runs.len(), number) {
            (1, _) => ("rec.csv".to_owned(), "twin.toml".to_owned()),
            (_, 0) => ("rec1.csv".to_owned(), "twin.toml".to_owned()),
            _ => (
                format!("rec{}.csv", number + 1),
                format!("twin{}.toml", number + 1),
            ),
        };
        put(&folder.join(rec), &recording(rig, rows))?;
        put(&folder.join(toml), &twin(rig))?;
        if number == 0 && rig.disc_known {
            put(&folder.join("errors.csv"), &errors(rig))?;
        }
    }
    Ok(())
}

/// Writes the truth of a case.
///
/// # Errors
/// If it cannot be written.
pub fn sealed(folder: &Path, truth: &Value) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let text = serde_json::to_string_pretty(truth)?;
    put(&folder.join("truth.json"), &(text + "\n"))
}

fn put(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
