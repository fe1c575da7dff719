//! Reading a reference and looking angles up in it.

use super::*;

fn read(text: &str) -> Result<Reference, String> {
    Reference::read(text.as_bytes(), "ref.csv", 2.0).map_err(|error| error.to_string())
}

#[test]
fn angles_are_interpolated_and_divided_by_the_ratio() {
    let reference = read("time,angle_rad\n0,0\n1,4\n2,4\n").unwrap();
    let mut hint = 0;
    assert_eq!(reference.angle_at(0.25, &mut hint), Some(0.5));
    assert_eq!(reference.angle_at(1.5, &mut hint), Some(2.0));
    assert_eq!(reference.angle_at(2.5, &mut hint), None);
    // Delays taken off, times may go back a little.
    assert_eq!(reference.angle_at(0.5, &mut hint), Some(1.0));
}

#[test]
fn every_fault_names_its_line() {
    let cases = [
        (
            "time,angle\n0,0\n",
            "ref.csv:1: no column 'angle_rad' (found: time, angle)",
        ),
        (
            "time,angle_rad\n0,0\n1,x\n",
            "ref.csv:3: 'x' in column 'angle_rad' is not a finite number",
        ),
        ("time,angle_rad\n0,0\n1,NaN\n", "ref.csv:3: 'NaN'"),
        (
            "time,angle_rad\n1,0\n1,1\n",
            "ref.csv:3: time 1 s is not after",
        ),
        (
            "time,angle_rad\n1,0\n",
            "ref.csv: a reference needs at least two rows, this one has 1",
        ),
    ];
    for (text, expected) in cases {
        let error = read(text).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
    }
}
