//! Curves as SVG: panels below each other, each with its axes and a legend.

use std::ops::Range;
use std::path::Path;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::{
    BLACK, Cartesian2d, ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, IntoLogRange,
    LineSeries, PathElement, RGBColor, Ranged, SVGBackend, SeriesLabelPosition, WHITE,
};

use crate::output::statistics::Interval;
use crate::output::{OutputError, atomic, extension};

/// Size of a panel in pixels.
const PANEL: (u32, u32) = (900, 480);
/// Room beyond the outermost points, as a share of the range or, on logarithmic axes, a factor.
const ROOM: f64 = 0.08;
const COLORS: [RGBColor; 6] = [
    RGBColor(27, 79, 156),
    RGBColor(196, 98, 26),
    RGBColor(43, 138, 62),
    RGBColor(139, 47, 160),
    RGBColor(176, 36, 54),
    RGBColor(90, 90, 90),
];

/// Curves over the same axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// What is drawn.
    pub curves: Vec<Curve>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it counts.
    pub label: String,
    /// How.
    pub scale: Scale,
}

/// How an axis counts.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By factors.
    Logarithmic,
    /// These names, at 0, 1, ...
    Names(Vec<String>),
}

impl Axis {
    /// An axis that counts evenly.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// An axis that counts by factors.
    pub fn logarithmic(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic }
    }

    /// An axis with names.
    pub fn names(names: Vec<String>) -> Self {
        Self { label: String::new(), scale: Scale::Names(names) }
    }
}

/// Points that belong together; a line joins them unless they stand at names.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name in the legend; none if it has none.
    pub name: String,
    /// From left to right.
    pub points: Vec<Point>,
}

/// A point with the interval that it lies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    x: f64,
    y: f64,
    low: f64,
    high: f64,
}

impl Point {
    /// A point as such.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, low: y, high: y }
    }

    /// The same within an interval, if one is known.
    pub fn within(self, interval: Option<Interval>) -> Self {
        interval.map_or(self, |Interval { low, high, .. }| Self { low, high, ..self })
    }
}

/// Checks before a long measurement that [`write`] can write there.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    match extension(path).as_str() {
        "svg" => atomic::probe_writable(path),
        _ => Err(OutputError::Extension { path: path.to_owned(), known: ".svg (plots are SVG)" }),
    }
}

/// Draws panels to a file.
pub fn write(panels: &[Panel], path: &Path) -> Result<(), OutputError> {
    check_writable(path)?;
    let text = svg(panels).map_err(|reason| OutputError::unwritable(path, reason))?;
    atomic::write(path, text.as_bytes())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn svg(panels: &[Panel]) -> Result<String, String> {
    let mut text = String::new();
    let (width, height) = PANEL;
    let count = panels.len().max(1);
    let backend = SVGBackend::with_string(&mut text, (width, height * count as u32));
    let root = backend.into_drawing_area();
    root.fill(&WHITE).map_err(in_words)?;
    for (area, panel) in root.split_evenly((count, 1)).iter().zip(panels) {
        draw(area, panel)?;
    }
    root.present().map_err(in_words)?;
    drop(root);
    Ok(text)
}

/// Chooses the axes.
fn draw(area: &Area, panel: &Panel) -> Result<(), String> {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let x = range_of(points().map(|point| point.x), &panel.x);
    let y = range_of(points().flat_map(|point| [point.low, point.y, point.high]), &panel.y);
    let is_log = |axis: &Axis| axis.scale == Scale::Logarithmic;
    match (is_log(&panel.x), is_log(&panel.y)) {
        (true, true) => draw_on(area, panel, x.log_scale(), y.log_scale()),
        (true, false) => draw_on(area, panel, x.log_scale(), y),
        (false, true) => draw_on(area, panel, x, y.log_scale()),
        (false, false) => draw_on(area, panel, x, y),
    }
}

/// What an axis shows of these values: all that it can, with some room.
fn range_of(values: impl Iterator<Item = f64>, axis: &Axis) -> Range<f64> {
    let shown = values.filter(|value| is_shown(*value, axis));
    let (low, high) =
        shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    match &axis.scale {
        Scale::Names(names) => -0.5..names.len().max(1) as f64 - 0.5,
        _ if low > high => 0.5..1.5,
        Scale::Logarithmic => {
            let room = (high / low).powf(ROOM).max(1.2);
            low / room..high * room
        }
        Scale::Linear => {
            let room = (ROOM * (high - low)).max(0.05 * high.abs()).max(f64::MIN_POSITIVE);
            low - room..high + room
        }
    }
}

/// Whether a value has a place on an axis.
fn is_shown(value: f64, axis: &Axis) -> bool {
    value.is_finite() && (value > 0.0 || axis.scale != Scale::Logarithmic)
}

fn draw_on<X, Y>(area: &Area, panel: &Panel, x: X, y: Y) -> Result<(), String>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(76)
        .build_cartesian_2d(x, y)
        .map_err(in_words)?;
    let ticks = match &panel.x.scale {
        Scale::Names(names) => 2 * names.len() + 1,
        _ => 10,
    };
    chart
        .configure_mesh()
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
        .x_labels(ticks)
        .x_label_formatter(&|value| tick(*value, &panel.x))
        .y_label_formatter(&|value| tick(*value, &panel.y))
        .label_style(("sans-serif", 13))
        .draw()
        .map_err(in_words)?;
    for (curve, color) in panel.curves.iter().zip(COLORS.iter().cycle()) {
        draw_curve(&mut chart, panel, curve, *color)?;
    }
    if panel.curves.iter().any(|curve| !curve.name.is_empty()) {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 13))
            .draw()
            .map_err(in_words)?;
    }
    Ok(())
}

type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

fn draw_curve<X, Y>(
    chart: &mut Chart<'_, '_, X, Y>,
    panel: &Panel,
    curve: &Curve,
    color: RGBColor,
) -> Result<(), String>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let is_shown =
        |point: &&Point| is_shown(point.x, &panel.x) && is_shown(point.low.min(point.y), &panel.y);
    let points: Vec<&Point> = curve.points.iter().filter(is_shown).collect();
    let intervals = points.iter().filter(|point| point.high > point.low);
    let bars = intervals.map(|point| {
        PathElement::new(vec![(point.x, point.low), (point.x, point.high)], color.stroke_width(2))
    });
    chart.draw_series(bars).map_err(in_words)?;
    if !matches!(panel.x.scale, Scale::Names(_)) {
        let line = points.iter().map(|point| (point.x, point.y));
        chart.draw_series(LineSeries::new(line, color.stroke_width(1))).map_err(in_words)?;
    }
    let dots = points.iter().map(|point| Circle::new((point.x, point.y), 4, color.filled()));
    let drawn = chart.draw_series(dots).map_err(in_words)?;
    if !curve.name.is_empty() {
        drawn.label(&curve.name).legend(move |(x, y)| Circle::new((x + 8, y), 4, color.filled()));
    }
    Ok(())
}

fn in_words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// What stands at a tick.
fn tick(value: f64, axis: &Axis) -> String {
    match &axis.scale {
        Scale::Names(names) => {
            let is_name = value >= 0.0 && value.fract() == 0.0;
            let name = is_name.then(|| names.get(value as usize)).flatten();
            name.cloned().unwrap_or_default()
        }
        _ => match value.abs() {
            0.0 => "0".into(),
            1e-3..1e5 => {
                let text = format!("{value:.4}");
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            }
            _ => format!("{value:.0e}"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(x: Axis, y: Axis, points: &[(f64, f64)]) -> Panel {
        let points = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let curve = Curve { name: "a < b".into(), points };
        Panel { title: "t & u".into(), x, y, curves: vec![curve] }
    }

    #[test]
    fn points_without_a_place_are_left_out_and_text_is_escaped() {
        let log = || Axis::logarithmic("n");
        let points = [(1.0, 1.0), (10.0, 0.0), (100.0, f64::NAN), (1000.0, 4.0)];
        let text = svg(&[panel(log(), log(), &points)]).unwrap();
        // One dot in the legend.
        assert_eq!(text.matches("<circle").count(), 3, "{text}");
        assert!(text.contains("a &lt; b") && text.contains("t &amp; u"), "{text}");
        let text = svg(&[panel(Axis::linear("n"), Axis::linear("m"), &points)]).unwrap();
        assert_eq!(text.matches("<circle").count(), 4, "{text}");
    }

    #[test]
    fn nothing_to_draw_is_no_failure() {
        for (x, y) in
            [(Axis::linear(""), Axis::logarithmic("")), (Axis::names(vec![]), Axis::linear(""))]
        {
            svg(&[panel(x, y, &[])]).unwrap();
        }
        svg(&[panel(Axis::linear(""), Axis::linear(""), &[(0.0, 0.0)])]).unwrap();
        svg(&[]).unwrap();
    }

    #[test]
    fn names_stand_at_their_points() {
        let names = Axis::names(vec!["mirror".into(), "tank".into()]);
        let text = svg(&[panel(names, Axis::linear(""), &[(0.0, 1.0), (1.0, 2.0)])]).unwrap();
        assert_eq!((text.matches("mirror").count(), text.matches("tank").count()), (1, 1));
    }
}
