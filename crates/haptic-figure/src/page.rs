//! A page: title, subtitle, legend, and panels in rows.
//!
//! The legend stands above the panels, where it cannot cover a curve. Labels that all panels share
//! and that are too long for one of them stand once, beside or below them all.

use crate::curve::{BoxEdges, Form, SAMPLE_LENGTH};
use crate::drawing::{Anchor, Drawing, Item, Text};
use crate::panel::{Frame, Panel};
use crate::style::{
    LABEL_SIZE, MUTED_INK, PAGE_EDGE, PAGE_WIDTH, SMALLEST_TITLE_SIZE, SUBTITLE_SIZE, Sizes,
    TITLE_SIZE, fit, fit_between, text_width,
};
use crate::{FigureError, Picture};

const TITLE_BASELINE: f64 = 34.0;
const SUBTITLE_BASELINE: f64 = 60.0;
/// From one line of the subtitle to the next.
const SUBTITLE_LINE: f64 = 22.0;
/// From there to the first line of the legend, and to further ones.
const LEGEND_BELOW: f64 = 28.0;
const LEGEND_LINE: f64 = 25.0;
/// Between a sample and its name, and from there to the next sample.
const SAMPLE_GAP: f64 = 10.0;
const ENTRY_GAP: f64 = 28.0;
/// From the last baseline above the panels to their top.
const PANELS_BELOW: f64 = 12.0;
/// Between the headings of panels side by side.
const HEADING_GAP: f64 = 10.0;
/// Room for a label that all panels share.
const SHARED_LABEL: f64 = 24.0;
/// All curves of a page have about so many points, which keeps its SVG below half a megabyte.
const POINTS_OF_A_PAGE: usize = 20_000;

/// A row of panels, whose boxes have equal width.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) height: f64,
    /// Places for panels; those on the right may be free, but not in the first row.
    pub(crate) columns: usize,
    pub(crate) panels: Vec<Panel>,
}

/// A name in the legend and what it stands for, one over the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LegendEntry {
    pub(crate) name: String,
    pub(crate) forms: Vec<Form>,
}

impl LegendEntry {
    pub(crate) fn new(name: &str, form: Form) -> Self {
        Self {
            name: name.to_owned(),
            forms: vec![form],
        }
    }
}

/// A page; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Page {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) legend: Vec<LegendEntry>,
    pub(crate) sizes: Sizes,
    pub(crate) rows: Vec<Row>,
    /// Labels of all horizontal and of all vertical axes; empty if these have their own.
    pub(crate) x_label: String,
    pub(crate) y_label: String,
}

impl Page {
    pub(crate) fn draw(mut self) -> Result<Picture, FigureError> {
        let legend = self.legend_lines();
        let header = match legend.len() {
            0 => self.title_end(),
            lines => self.title_end() + LEGEND_BELOW + (lines - 1) as f64 * LEGEND_LINE,
        };
        let panels_top = header + PANELS_BELOW;
        let rows_height = self.rows.iter().map(|row| row.height).sum::<f64>();
        let height = panels_top + rows_height + room_of(&self.x_label) + PAGE_EDGE;
        let mut drawing = Drawing::new(PAGE_WIDTH, height);
        self.draw_header(&mut drawing, &legend);
        let frames = self.place();
        self.draw_shared_labels(&mut drawing, &frames, panels_top, rows_height);
        self.draw_panels(&mut drawing, &frames, panels_top);
        Picture::new(drawing)
    }

    /// Fits all axes and finds the frame of each panel with its left edge on the page.
    fn place(&mut self) -> Vec<Vec<(f64, Frame)>> {
        let sizes = self.sizes;
        let mut bottoms = Vec::new();
        for row in &mut self.rows {
            let margins = row.panels.iter().map(|panel| panel.margin_bottom(sizes));
            let bottom = row.height - margins.fold(0.0, f64::max);
            for panel in &mut row.panels {
                panel.fit_y(bottom - sizes.top, sizes);
            }
            bottoms.push(bottom);
        }
        let panels = self.rows.iter().flat_map(|row| &row.panels);
        let curves = panels.map(|panel| panel.curves.len()).sum::<usize>();
        let most_points = POINTS_OF_A_PAGE / curves.max(1);
        let page_left = PAGE_EDGE + room_of(&self.y_label);
        let lefts: Vec<Vec<f64>> = (self.rows.iter())
            .map(|row| self.margins_left(row.columns))
            .collect();
        let mut frames = Vec::new();
        for ((row, lefts), bottom) in self.rows.iter_mut().zip(lefts).zip(bottoms) {
            let margins = lefts.iter().map(|left| left + sizes.right).sum::<f64>();
            let boxes = PAGE_WIDTH - PAGE_EDGE - page_left - margins;
            let box_width = boxes / row.columns as f64;
            let mut x = page_left;
            let mut placed = Vec::new();
            for (panel, left) in row.panels.iter_mut().zip(lefts) {
                panel.fit_x(box_width, sizes);
                let edges = BoxEdges {
                    left,
                    right: left + box_width,
                    top: sizes.top,
                    bottom,
                };
                let frame = Frame {
                    width: edges.right + sizes.right,
                    height: row.height,
                    edges,
                    sizes,
                    most_points,
                };
                placed.push((x, frame));
                x += frame.width;
            }
            frames.push(placed);
        }
        frames
    }

    /// Space to the left of each box in rows of so many columns. Boxes stand in line: all columns
    /// with axis labels have one margin, and all without.
    fn margins_left(&self, columns: usize) -> Vec<f64> {
        let widest = |labelled: bool| {
            let panels = self.rows.iter().flat_map(|row| &row.panels);
            let panels = panels.filter(|panel| panel.y.label.is_empty() != labelled);
            let margins = panels.map(|panel| panel.margin_left(self.sizes));
            margins.fold(0.0, f64::max)
        };
        let (labelled, bare) = (widest(true), widest(false));
        let rows: Vec<&Row> = (self.rows.iter())
            .filter(|row| row.columns == columns)
            .collect();
        let has_label = |column: usize| {
            let mut panels = rows.iter().filter_map(|row| row.panels.get(column));
            panels.any(|panel| !panel.y.label.is_empty())
        };
        (0..columns)
            .map(|column| if has_label(column) { labelled } else { bare })
            .collect()
    }

    fn draw_panels(&self, drawing: &mut Drawing, frames: &[Vec<(f64, Frame)>], top: f64) {
        let alone = self.rows.iter().map(|row| row.panels.len()).sum::<usize>() == 1;
        let heading = |panel: &Panel| match panel.caption.as_str() {
            caption if alone => caption.to_owned(),
            "" => format!("({})", panel.name),
            caption => format!("({}) {caption}", panel.name),
        };
        // A heading reaches to the next one, and all have one size.
        let room = |row: &[(f64, Frame)], column: usize| {
            let start = |(x, frame): &(f64, Frame)| x + frame.edges.left;
            let end = row.get(column + 1).map(|next| start(next) - HEADING_GAP);
            end.unwrap_or(PAGE_WIDTH) - start(&row[column])
        };
        let mut size = self.sizes.label;
        for (row, frames) in self.rows.iter().zip(frames) {
            for (column, panel) in row.panels.iter().enumerate() {
                size = fit(&heading(panel), size, room(frames, column)).1;
            }
        }
        let mut y = top;
        for (row, frames) in self.rows.iter().zip(frames) {
            for (column, (panel, (x, frame))) in row.panels.iter().zip(frames).enumerate() {
                let (heading, size) = fit(&heading(panel), size, room(frames, column));
                drawing.items.push(Item::Moved {
                    by: (*x, y),
                    items: panel.draw(*frame, &heading, size),
                });
            }
            y += row.height;
        }
    }

    /// The labels that all panels share, around the middles of all boxes.
    fn draw_shared_labels(
        &self,
        drawing: &mut Drawing,
        frames: &[Vec<(f64, Frame)>],
        top: f64,
        rows_height: f64,
    ) {
        let size = self.sizes.label;
        let first = frames.first().and_then(|row| row.first());
        let last = frames.first().and_then(|row| row.last());
        let (Some((left, first)), Some((right, last))) = (first, last) else {
            return;
        };
        if !self.x_label.is_empty() {
            let (left, right) = (left + first.edges.left, right + last.edges.right);
            let (label, size) = fit(&self.x_label, size, right - left);
            let x = (left + right) / 2.0;
            let y = top + rows_height + 0.9 * f64::from(size);
            drawing.text(Text::new(&label, x, y, size).anchored(Anchor::Middle));
        }
        if !self.y_label.is_empty() {
            let bottom = frames.last().and_then(|row| row.last());
            let below = bottom.map_or(0.0, |(_, frame)| frame.height - frame.edges.bottom);
            let (top, bottom) = (top + first.edges.top, top + rows_height - below);
            let (label, size) = fit(&self.y_label, size, bottom - top);
            let x = PAGE_EDGE + f64::from(size);
            let text = Text::new(&label, x, (top + bottom) / 2.0, size).anchored(Anchor::Middle);
            drawing.text(Text {
                upright: true,
                ..text
            });
        }
    }

    /// Baseline of the last line of title and subtitle.
    fn title_end(&self) -> f64 {
        match self.subtitle.lines().count() {
            0 => TITLE_BASELINE,
            lines => SUBTITLE_BASELINE + (lines - 1) as f64 * SUBTITLE_LINE,
        }
    }

    /// The entries of the legend in lines, each entry with its left edge.
    fn legend_lines(&self) -> Vec<Vec<(f64, &LegendEntry)>> {
        let left = 2.0 * PAGE_EDGE;
        let mut lines: Vec<Vec<(f64, &LegendEntry)>> = Vec::new();
        let mut x = left;
        for entry in &self.legend {
            let width = SAMPLE_LENGTH + SAMPLE_GAP + text_width(&entry.name, LABEL_SIZE);
            if lines.is_empty() || x + width > PAGE_WIDTH - left {
                lines.push(Vec::new());
                x = left;
            }
            if let Some(line) = lines.last_mut() {
                line.push((x, entry));
            }
            x += width + ENTRY_GAP;
        }
        lines
    }

    fn draw_header(&self, drawing: &mut Drawing, legend: &[Vec<(f64, &LegendEntry)>]) {
        let left = 2.0 * PAGE_EDGE;
        let room = PAGE_WIDTH - 2.0 * left;
        let sizes = SMALLEST_TITLE_SIZE..=TITLE_SIZE;
        let (title, size) = fit_between(&self.title, sizes, room);
        drawing.text(Text::new(&title, left, TITLE_BASELINE, size));
        for (line, subtitle) in self.subtitle.lines().enumerate() {
            let (subtitle, size) = fit(subtitle, SUBTITLE_SIZE, room);
            let baseline = SUBTITLE_BASELINE + line as f64 * SUBTITLE_LINE;
            drawing.text(Text {
                colour: MUTED_INK,
                ..Text::new(&subtitle, left, baseline, size)
            });
        }
        for (line, entries) in legend.iter().enumerate() {
            let baseline = self.title_end() + LEGEND_BELOW + line as f64 * LEGEND_LINE;
            for (x, entry) in entries {
                for form in &entry.forms {
                    let middle = baseline - 0.35 * f64::from(LABEL_SIZE);
                    drawing.items.append(&mut form.sample(*x, middle));
                }
                let x = x + SAMPLE_LENGTH + SAMPLE_GAP;
                let (name, size) = fit(&entry.name, LABEL_SIZE, PAGE_WIDTH - left - x);
                drawing.text(Text::new(&name, x, baseline, size));
            }
        }
    }
}

/// What a label takes that all panels share.
const fn room_of(label: &str) -> f64 {
    if label.is_empty() { 0.0 } else { SHARED_LABEL }
}
