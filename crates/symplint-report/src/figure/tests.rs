//! Whole figures.

use std::fs;
use std::path::PathBuf;

use super::font::Typeface;
use super::scene::{Align, Mark, Scene, Text};
use super::{Axis, Figure, FigureError, Panel, Scale, Series, Style, draw};

pub(super) fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.to_string(),
        scale,
        range: None,
    }
}

pub(super) fn series(label: &str, points: Vec<(f64, f64)>, style: Style, color: usize) -> Series {
    Series {
        label: label.to_string(),
        points,
        style,
        color,
    }
}

pub(super) fn panel(series: Vec<Series>) -> Panel {
    Panel {
        title: String::new(),
        x: axis("x", Scale::Linear),
        y: axis("y", Scale::Linear),
        series,
        equal_aspect: false,
    }
}

fn figure(panels: Vec<Panel>) -> Figure {
    Figure::new(panels, 2)
}

/// A folder of this test alone, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("figure-{test}-{}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder left behind fails no test.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Defects over step sizes, with the usual trouble in them.
fn troubled(y: Scale) -> Panel {
    let values = [1e-2, 0.0, f64::NAN, 1e-9, -1e-5, f64::INFINITY, 1e-16, 0.0];
    let points: Vec<(f64, f64)> = values
        .iter()
        .enumerate()
        .map(|(k, value)| (0.5_f64.powi(k as i32), *value))
        .collect();
    let styles = [
        Style::Line,
        Style::Points,
        Style::LineAndPoints,
        Style::Dashed,
        Style::Uncertainty,
        Style::Closed,
        Style::Thin,
    ];
    let mut panel = panel(
        styles
            .iter()
            .enumerate()
            .map(|(k, style)| series(&format!("{style:?}"), points.clone(), *style, k))
            .collect(),
    );
    panel.title = "Trouble <&\"> \u{1F980}".to_string();
    panel.x = axis("step size h", Scale::Log2);
    panel.y = axis("relative loop defect |E|", y);
    panel
}

#[test]
fn both_files_are_written_whatever_the_data() {
    let folder = Folder::new("written");
    let mut empty = panel(Vec::new());
    empty.equal_aspect = true;
    let figure = figure(vec![
        troubled(Scale::Log10),
        troubled(Scale::Log2),
        troubled(Scale::Linear),
        empty,
        panel(vec![series("one", vec![(1.0, 1.0)], Style::Closed, 9)]),
    ]);
    figure
        .save(&folder.0, "all")
        .expect("the figure is written");
    let svg = fs::read_to_string(folder.0.join("all.svg")).expect("the SVG is there");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    assert!(svg.contains("sans-serif") && svg.contains("Trouble &lt;&amp;&quot;&gt;"));
    let png = fs::read(folder.0.join("all.png")).expect("the PNG is there");
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn extreme_values_stay_inside_the_page() {
    let face = Typeface::load().expect("the built-in font is readable");
    let values = [
        f64::MAX,
        5e-324,
        1.0,
        f64::MIN,
        1e300,
        -1e-300,
        f64::MIN_POSITIVE,
    ];
    let points: Vec<(f64, f64)> = values.iter().map(|y| (*y, *y)).collect();
    for scale in [Scale::Linear, Scale::Log10, Scale::Log2] {
        for range in [None, Some((1.0, 1.0 + 1e-6))] {
            let mut panel = panel(vec![
                series("a", points.clone(), Style::LineAndPoints, 3),
                series("b", points.clone(), Style::Uncertainty, 0),
            ]);
            panel.x.scale = scale;
            panel.y.scale = scale;
            panel.x.range = range;
            panel.y.range = range;
            let scene = draw::scene(&figure(vec![panel]), &face);
            for mark in &scene.marks {
                if let Mark::Line { points, .. } | Mark::Area { points, .. } = mark {
                    for (x, y) in points {
                        assert!((0.0..=scene.width).contains(x), "{scale:?} {range:?} {x}");
                        assert!((0.0..=scene.height).contains(y), "{scale:?} {range:?} {y}");
                    }
                }
            }
        }
    }
}

#[test]
fn zeros_are_triangles_at_the_bottom_and_lone_points_are_dots() {
    let face = Typeface::load().expect("the built-in font is readable");
    let mut one = panel(vec![series(
        "a",
        vec![
            (1.0, 0.0),
            (2.0, 1e-3),
            (3.0, 0.0),
            (4.0, 1e-2),
            (5.0, 1e-2),
        ],
        Style::Line,
        0,
    )]);
    one.y.scale = Scale::Log10;
    let scene = draw::scene(&figure(vec![one.clone()]), &face);
    let texts = text_boxes(&scene, &face);
    assert!(texts.iter().any(|(_, text)| text == "exactly 0"));
    let dots = scene
        .marks
        .iter()
        .filter(|mark| matches!(mark, Mark::Disc { .. }));
    assert_eq!(dots.count(), 1);

    one.y.scale = Scale::Linear;
    let scene = draw::scene(&figure(vec![one]), &face);
    let texts = text_boxes(&scene, &face);
    assert!(texts.iter().all(|(_, text)| text != "exactly 0"));
}

#[test]
fn errors_name_the_path() {
    let folder = Folder::new("errors");
    let error = figure(Vec::new()).save(&folder.0, "none").unwrap_err();
    assert!(matches!(error, FigureError::NoPanels { .. }));
    assert!(error.to_string().contains("none"));

    fs::create_dir_all(folder.0.join("taken.svg")).expect("a folder in the way");
    let figure = figure(vec![panel(Vec::new())]);
    let error = figure.save(&folder.0, "taken").unwrap_err();
    assert!(matches!(error, FigureError::Write { .. }));
    assert!(error.to_string().contains("taken.svg"));

    fs::write(folder.0.join("file"), "").expect("a file in the way");
    let error = figure.save(&folder.0.join("file"), "x").unwrap_err();
    assert!(matches!(error, FigureError::Folder { .. }));
}

#[test]
fn a_long_series_makes_a_small_file() {
    let folder = Folder::new("small");
    let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
    let points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), noise(k))).collect();
    for style in [Style::Line, Style::Points, Style::LineAndPoints] {
        let figure = figure(vec![panel(vec![series("noise", points.clone(), style, 0)])]);
        figure
            .save(&folder.0, "long")
            .expect("the figure is written");
        let bytes = fs::metadata(folder.0.join("long.svg")).map_or(0, |file| file.len());
        assert!((1..500_000).contains(&bytes), "{style:?}: {bytes} bytes");
    }
}

#[test]
fn texts_stay_on_the_page_and_off_each_other() {
    let face = Typeface::load().expect("the built-in font is readable");
    let mut wide = panel(vec![series(
        "a rather long legend entry",
        (0..50)
            .map(|k| (f64::from(k) * 2e5, f64::from(k * k) * -3e-7))
            .collect(),
        Style::LineAndPoints,
        1,
    )]);
    wide.title = "a title that is much too long for one panel of this width ".repeat(3);
    wide.y.label = "a label that is much too long for the height of this panel".to_string();
    let figure = figure(vec![troubled(Scale::Log10), troubled(Scale::Linear), wide])
        .with_title("all scales");
    let scene = draw::scene(&figure, &face);
    let boxes = text_boxes(&scene, &face);
    assert!(boxes.len() > 40);
    for (k, (a, name)) in boxes.iter().enumerate() {
        assert!(
            a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= scene.width && a[3] <= scene.height,
            "{name} leaves the page: {a:?}"
        );
        for (b, other) in &boxes[k + 1..] {
            let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
            assert!(apart, "{name} {a:?} overlaps {other} {b:?}");
        }
    }
}

/// Left, top, right and bottom of every text.
fn text_boxes(scene: &Scene, face: &Typeface) -> Vec<([f64; 4], String)> {
    let texts = scene.marks.iter().filter_map(|mark| match mark {
        Mark::Text(text) => Some(text),
        _ => None,
    });
    texts
        .map(|text| (text_box(text, face), text.text.clone()))
        .collect()
}

fn text_box(text: &Text, face: &Typeface) -> [f64; 4] {
    let width = face.width(&text.text, text.size);
    let before = match text.align {
        Align::Start => 0.0,
        Align::Middle => 0.5 * width,
        Align::End => width,
    };
    let (x, y) = text.at;
    let (up, down) = (0.76 * text.size, 0.2 * text.size);
    if text.upwards {
        [x - up, y + before - width, x + down, y + before]
    } else {
        [x - before, y - up, x - before + width, y + down]
    }
}

#[test]
fn the_text_of_a_figure_is_that_of_its_file() {
    let folder = Folder::new("text");
    let drawn = figure(vec![troubled(Scale::Log10)]);
    drawn.save(&folder.0, "file").unwrap();
    let file = fs::read_to_string(folder.0.join("file.svg")).unwrap();
    assert_eq!(drawn.to_svg().unwrap(), file);
    assert!(matches!(
        figure(Vec::new()).to_svg(),
        Err(FigureError::NoPanels { .. })
    ));
}
