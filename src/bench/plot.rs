//! Curves as SVG: panels below each other, each with its axes and a legend.

use std::ops::Range;
use std::path::Path;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::{
    BLACK, Cartesian2d, ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, LineSeries,
    PathElement, RGBColor, Ranged, SVGBackend, SeriesLabelPosition, WHITE,
};

use crate::image::{OutputError, atomic, extension};
use crate::math::elementary::{ln, log10, pow};
use crate::math::statistics::Interval;

/// Size of a panel in pixels.
const PANEL: (u32, u32) = (900, 480);
/// Room beyond the outermost points, as a share of the range, of its exponents where axes are
/// logarithmic.
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

/// Checks before a long measurement that [`write()`] can write there.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    match extension(path).as_str() {
        "svg" => atomic::probe_writable(path),
        _ => Err(OutputError::Extension {
            path: path.to_owned(),
            known: ".svg (plots are SVG)".to_owned(),
        }),
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

/// An axis with what it shows.
struct Shown {
    range: Range<f64>,
    is_logarithmic: bool,
    ticks: Vec<f64>,
}

impl Shown {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let range = range_of(values, axis);
        let ticks = ticks(&range, axis);
        Self { range, is_logarithmic: axis.scale == Scale::Logarithmic, ticks }
    }
}

impl Ranged for Shown {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let place = |value: f64| if self.is_logarithmic { ln(value) } else { value };
        let [start, end] = [self.range.start, self.range.end].map(place);
        let share = (place(*value) - start) / (end - start);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
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
            let room = pow(high / low, ROOM).max(1.2);
            low / room..high * room
        }
        Scale::Linear => {
            let room = (ROOM * (high - low)).max(0.05 * high.abs());
            let room = if room > 0.0 { room } else { 0.5 };
            low - room..high + room
        }
    }
}

/// Where the ticks of an axis stand: at 1, 2 and 5 and their tenfolds, by factors, or so that
/// there are a few; or at the names.
fn ticks(range: &Range<f64>, axis: &Axis) -> Vec<f64> {
    let &Range { start, end } = range;
    if let Scale::Names(names) = &axis.scale {
        return (0..names.len()).map(|index| index as f64).collect();
    }
    if axis.scale == Scale::Linear {
        let least = (end - start) / 8.0;
        let tenfold = pow(10.0, log10(least).floor());
        let step = [1.0, 2.0, 5.0].map(|step| step * tenfold).into_iter().find(|s| *s >= least);
        let step = step.unwrap_or(10.0 * tenfold);
        let [first, last] = [(start / step).ceil(), (end / step).floor()].map(|edge| edge as i64);
        return (first..=last).map(|index| index as f64 * step).collect();
    }
    let exponents = log10(start).floor() as i32..=log10(end).ceil() as i32;
    let steps: &[f64] = if exponents.clone().count() > 5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let ticks = exponents.flat_map(|power| steps.iter().map(move |s| s * 10_f64.powi(power)));
    ticks.filter(|tick| range.contains(tick)).collect()
}

/// Whether a value has a place on an axis.
fn is_shown(value: f64, axis: &Axis) -> bool {
    value.is_finite() && (value > 0.0 || axis.scale != Scale::Logarithmic)
}

fn draw(area: &Area, panel: &Panel) -> Result<(), String> {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let x = Shown::new(&panel.x, points().map(|point| point.x));
    let y = Shown::new(&panel.y, points().flat_map(|point| [point.low, point.y, point.high]));
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(76)
        .build_cartesian_2d(x, y)
        .map_err(in_words)?;
    chart
        .configure_mesh()
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
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
            .position(empty_corner(&panel.curves))
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 13))
            .draw()
            .map_err(in_words)?;
    }
    Ok(())
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Shown, Shown>>;

fn draw_curve(
    chart: &mut Chart,
    panel: &Panel,
    curve: &Curve,
    color: RGBColor,
) -> Result<(), String> {
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

/// The corner on the right that rising or falling curves leave empty.
fn empty_corner(curves: &[Curve]) -> SeriesLabelPosition {
    let rises = |curve: &Curve| match &curve.points[..] {
        [first, .., last] => (last.y - first.y).signum(),
        _ => 0.0,
    };
    match curves.iter().map(rises).sum::<f64>() > 0.0 {
        true => SeriesLabelPosition::LowerRight,
        false => SeriesLabelPosition::UpperRight,
    }
}

fn in_words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// What stands at a tick.
fn tick(value: f64, axis: &Axis) -> String {
    match &axis.scale {
        Scale::Names(names) => names.get(value as usize).cloned().unwrap_or_default(),
        Scale::Linear | Scale::Logarithmic => match value.abs() {
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
    fn ticks_are_round_and_few() {
        let linear = Axis::linear("");
        assert_eq!(ticks(&(0.9..3.1), &linear), [1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(ticks(&(-7.0..7.0), &linear), [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0]);
        let log = Axis::logarithmic("");
        assert_eq!(ticks(&(0.9..30.0), &log), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(&(0.5..2e6), &log), [0, 1, 2, 3, 4, 5, 6].map(|n| 10_f64.powi(n)));
    }

    #[test]
    fn names_stand_at_their_points() {
        let names = Axis::names(vec!["mirror".into(), "tank".into()]);
        let text = svg(&[panel(names, Axis::linear(""), &[(0.0, 1.0), (1.0, 2.0)])]).unwrap();
        assert_eq!((text.matches("mirror").count(), text.matches("tank").count()), (1, 1));
    }
}
