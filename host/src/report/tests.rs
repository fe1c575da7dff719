use super::plot::{Axis, Band, Bars, Heat, Histogram, Polar, Series, Spectrum, Strip, Xy};
use super::*;

const NASTY: &str = "<b>&\"'</title>";

fn parse(page: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(page, options).unwrap()
}

/// One of each kind of figure over the same values.
fn every_kind(x: &[f64], y: &[f64]) -> Vec<Plot> {
    let axes = || [Axis::new(NASTY, "s"), Axis::new(NASTY, "").log()];
    let mut out = vec![
        Plot::from(
            Spectrum::new("rad")
                .stems(NASTY, x, y, Colour::Blue)
                .floor(NASTY, x, y)
                .band(NASTY, x, y, x)
                .name(1.0, NASTY)
                .name(f64::NAN, NASTY),
        ),
        y.iter()
            .fold(Heat::new(NASTY, &[NASTY, "n"]), |heat, v| {
                heat.row(NASTY, &[Some(*v), None])
            })
            .into(),
        Strip::new(NASTY, "rad").turn(y).turn(&[]).turn(x).into(),
        Polar::new(Axis::new(NASTY, "rad"))
            .series(NASTY, x, y, Colour::Green)
            .into(),
    ];
    for axis in axes() {
        for style in [Series::line, Series::dashed, Series::step, Series::points] {
            let band = Band::new(NASTY, x, y, x, Colour::Grey);
            let plot = Xy::new(axis.clone(), axis.clone())
                .series(style(NASTY.to_owned(), x, y))
                .band(band);
            out.push(plot.mark_x(1.0, NASTY).mark_y(f64::NAN, NASTY).into());
        }
        out.push(
            Histogram::new(axis.clone())
                .values(NASTY, y, Colour::Sky)
                .into(),
        );
        out.push(
            y.iter()
                .take(20)
                .fold(Bars::new(axis), |b, v| b.bar(NASTY, *v, Colour::Purple))
                .into(),
        );
    }
    out
}

fn full_report(x: &[f64], y: &[f64]) -> Report {
    let mut report = Report::new(NASTY, NASTY);
    report
        .verdict(
            Level::Warn,
            NASTY,
            vec![
                Tile::new(NASTY, NASTY, NASTY, NASTY),
                Tile::si("x", f64::NAN, "s", ""),
            ],
        )
        .section(NASTY, &[NASTY])
        .table(
            NASTY,
            &[NASTY, "n"],
            vec![vec![NASTY.into(), 1.0.into()], vec![], vec![Cell::Empty; 4]],
        );
    for plot in every_kind(x, y) {
        report
            .figure(plot.clone(), NASTY)
            .figure_pair((plot.clone(), NASTY), (plot, ""));
    }
    let mut inner = Body::new();
    inner.section(NASTY, &[NASTY]);
    report.action(NASTY).body().card(
        NASTY,
        vec![(NASTY.to_owned(), vec![NASTY.to_owned()])],
        None,
        inner.clone(),
    );
    report.details(NASTY, inner).footer(Footer {
        version: NASTY.into(),
        command: NASTY.into(),
        inputs: vec![InputFile {
            name: NASTY.into(),
            bytes: 0,
            sha256: NASTY.into(),
        }],
    });
    report
}

#[test]
fn a_page_with_hostile_text_is_well_formed_and_says_it_as_text() {
    let page = full_report(&[1.0, 2.0, 3.0], &[0.5, 0.1, 2.0]).render();
    let document = parse(&page);
    let with = |tag: &str| {
        let node = document
            .descendants()
            .find(|n| n.has_tag_name(tag))
            .unwrap();
        node.text().unwrap().to_owned()
    };
    assert_eq!(with("h1"), NASTY);
    assert_eq!(with("code"), NASTY);
    assert!(
        document
            .descendants()
            .all(|n| !n.has_tag_name("b") && !n.has_tag_name("script"))
    );
    let label = document
        .descendants()
        .find_map(|n| n.attribute("aria-label").filter(|l| l.contains('<')));
    assert_eq!(label, Some(NASTY));
}

#[test]
fn degenerate_values_leave_the_page_whole_and_free_of_nan() {
    let bad = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -0.0,
        1e300,
        -1e300,
        5e-324,
        f64::MAX,
    ];
    let rows: [(&[f64], &[f64]); 8] = [
        (&[], &[]),
        (&[1.0], &[2.0]),
        (&[0.0], &[0.0]),
        (&[1.0, 2.0], &[7.0, 7.0]),
        (&[1.0, 2.0, 3.0], &[f64::NAN; 3]),
        (&bad, &bad),
        (&[1.0, 2.0, 3.0], &[1.0]),
        (&[3.0, 3.0, 3.0], &[1.0, -2.0, 1.0 + 1e-15]),
    ];
    for (x, y) in rows {
        let page = full_report(x, y).render();
        for node in parse(&page).descendants() {
            for a in node.attributes() {
                assert!(
                    !a.value().contains("NaN") && !a.value().contains("inf"),
                    "{a:?}"
                );
            }
        }
    }
}

#[test]
fn nothing_is_fetched_and_the_style_stays_out_of_the_markups_way() {
    let page = full_report(&[1.0, 2.0], &[1.0, 2.0]).render();
    let without_namespace = page.replace("http://www.w3.org/2000/svg", "");
    for fetched in ["http:", "https:", "url(", "@import", "src=", "<link"] {
        assert!(!without_namespace.contains(fetched), "{fetched}");
    }
}

#[test]
fn ten_figures_of_a_million_noisy_samples_stay_near_a_megabyte() {
    let n = 1_000_000u64;
    let x: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let y: Vec<f64> = (0..n)
        .map(|i| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64)
        .collect();
    let mut report = Report::new("size", "");
    for style in [Series::line, Series::step, Series::points] {
        report.figure(
            Xy::new(Axis::new("x", "s"), Axis::new("y", "rad")).series(style(
                "a".to_owned(),
                &x,
                &y,
            )),
            "",
        );
    }
    for _ in 0..4 {
        let plot = Xy::new(Axis::new("x", "s"), Axis::new("y", "rad"));
        report.figure(
            plot.series(Series::line("a", &x, &y))
                .series(Series::line("b", &x, &y)),
            "",
        );
    }
    report.figure(Spectrum::new("rad").stems("a", &x, &y, Colour::Blue), "");
    report.figure(
        (0..40).fold(Strip::new("e", "rad"), |s, i| {
            s.turn(&y[i * 10_000..][..10_000])
        }),
        "",
    );
    report.figure(
        Histogram::new(Axis::new("y", "rad")).values("a", &y, Colour::Blue),
        "",
    );
    let bytes = report.render().len();
    assert!(bytes < 1_300_000, "{bytes}");
}

#[test]
fn a_line_over_a_dense_one_stands_out_from_it() {
    let x: Vec<f64> = (0..10_000).map(f64::from).collect();
    let page = |below: &[f64]| {
        let plot = Xy::new(Axis::new("x", ""), Axis::new("y", ""))
            .series(Series::line("before", below, below).colour(Colour::BEFORE))
            .series(Series::line("after", &x, &x).colour(Colour::AFTER));
        let mut report = Report::new("t", "t");
        report.body().figure(plot, "c");
        report.render()
    };
    let over = |page: &str| page.contains("line blue over") && page.contains("class=\"casing\"");
    assert!(over(&page(&x)) && !over(&page(&x[..3])));
}

#[test]
fn few_points_have_tool_tips_and_many_have_none() {
    let tips = |n: usize| {
        let x: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let mut report = Report::new("t", "");
        report.figure(
            Xy::new(Axis::new("Time", "s"), Axis::new("Speed", "rad/s"))
                .series(Series::points("s", &x, &x)),
            "",
        );
        let page = report.render();
        (
            page.matches("<title>").count() - 1,
            page.contains("Speed 3.00\u{a0}rad/s"),
        )
    };
    assert_eq!(tips(200), (400, true));
    assert_eq!(tips(201), (0, false));
}

#[test]
fn writing_replaces_the_file_and_leaves_nothing_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("r.html");
    std::fs::write(&path, "old").unwrap();
    Report::new("new", "").write(&path).unwrap();
    assert!(
        std::fs::read_to_string(&path)
            .unwrap()
            .contains("<h1>new</h1>")
    );
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);

    let missing = dir.path().join("none/r.html");
    assert!(Report::new("x", "").write(&missing).is_err());
    assert!(Report::new("x", "").write(dir.path()).is_err());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}
