//! A page: title, subtitle, legend, and panels in rows.
//!
//! The legend stands above the panels, where it cannot cover a curve. Labels that all panels share
//! and that are too long for one of them stand once, beside or below them all.

use crate::axis::Axis;
use crate::curve::{BoxEdges, Form, SAMPLE_LENGTH};
use crate::drawing::{Anchor, Drawing, Item, Text};
use crate::panel::{Frame, Panel};
use crate::style::{
    INK, LABEL_SIZE, MUTED_INK, PAGE_EDGE, PAGE_WIDTH, SMALLEST_SIZE, SMALLEST_SUBTITLE_SIZE,
    SMALLEST_TITLE_SIZE, SUBTITLE_SIZE, Sizes, TITLE_SIZE, fit, text_width, wrapped,
};
use crate::{FigureError, Sheet};

const TITLE_BASELINE: f64 = 34.0;
/// Distance from one line of the title and of the subtitle to the next.
const TITLE_LINE: f64 = 26.0;
const SUBTITLE_LINE: f64 = 22.0;
/// Distance from there to the first line of the legend, and to further ones.
const LEGEND_BELOW: f64 = 28.0;
const LEGEND_LINE: f64 = 25.0;
/// Between a sample and its name, and from there to the next sample.
const SAMPLE_GAP: f64 = 10.0;
const ENTRY_GAP: f64 = 28.0;
/// Distance from the last baseline above the panels to their top.
const PANELS_BELOW: f64 = 12.0;
/// Between the headings of panels side by side.
const HEADING_GAP: f64 = 10.0;
/// Room for a label that all panels share.
const SHARED_LABEL: f64 = 24.0;
/// Approximate number of points of all curves of a page, which keeps its SVG below half a megabyte.
const POINTS_OF_A_PAGE: usize = 20_000;

/// Pixels of a page per metre of paper at which its smallest text has 6 points; a wider page has larger ones.
const PX_PER_METRE: f64 = SMALLEST_SIZE as f64 / 6.0 * 72.0 / 0.0254;
/// Height of a panel alone, px, and of the box of one that a narrow page makes lower.
const ONE_PANEL: f64 = 492.0;
const LEAST_BOX_HEIGHT: f64 = 160.0;

/// A row of panels, whose boxes have equal width.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    /// Height of a row that has a label below; without one it is drawn lower.
    pub(crate) height: f64,
    /// Places for panels; those on the right may be free, but not in the first row.
    pub(crate) columns: usize,
    pub(crate) panels: Vec<Panel>,
}

impl Row {
    /// Its height, which is less where no panel has a label below.
    fn drawn(&self, sizes: Sizes) -> f64 {
        let margins = self.panels.iter().map(|panel| panel.margin_bottom(sizes));
        self.height - sizes.bottom + margins.fold(0.0, f64::max)
    }

    /// Rows of `columns` of these panels; a last one beside a free place is as wide as two.
    pub(crate) fn of(height: f64, columns: usize, panels: Vec<Panel>) -> Vec<Self> {
        let mut panels = panels.into_iter();
        let mut rows = Vec::new();
        while panels.len() > 0 {
            let columns = if columns == 2 {
                panels.len().min(2)
            } else {
                columns
            };
            rows.push(Self {
                height,
                columns,
                panels: panels.by_ref().take(columns).collect(),
            });
        }
        rows
    }
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
    /// Width, px, and that on paper, m.
    pub(crate) width: f64,
    pub(crate) printed_m: Option<f64>,
}

impl Page {
    /// The page as it is printed on a sheet.
    pub(crate) fn on(mut self, sheet: &Sheet) -> Result<Self, FigureError> {
        let before = self.width;
        if sheet.untitled {
            self.title.clear();
            self.subtitle.clear();
        }
        if let Some(wanted) = &sheet.panel {
            self.keep(wanted)?;
        }
        if let Some(width_m) = sheet.width_m {
            if !Sheet::WIDTHS_M.contains(&width_m) {
                return Err(FigureError::Width { width_m });
            }
            self.width = (width_m * PX_PER_METRE).min(PAGE_WIDTH);
            self.printed_m = Some(width_m);
        }
        self.reflow(self.width / before);
        Ok(self)
    }

    /// Keeps one panel, and of the legend what is in it.
    fn keep(&mut self, wanted: &str) -> Result<(), FigureError> {
        let panels = self.rows.iter().flat_map(|row| &row.panels);
        let names = panels.map(|panel| format!("{} ({})", panel.name, panel.caption));
        let known = names.collect::<Vec<_>>().join(", ");
        let rows = std::mem::take(&mut self.rows).into_iter();
        let mut panels = rows.flat_map(|row| row.panels);
        let panel = panels.find(|panel| panel.is_called(&wanted.to_lowercase()));
        let wanted = wanted.to_owned();
        let panel = panel.ok_or(FigureError::Panel { wanted, known })?;
        self.legend.retain(|entry| {
            let mut curves = panel.curves.iter();
            curves.any(|curve| entry.forms.contains(&curve.form))
        });
        self.rows = Row::of(ONE_PANEL, 1, vec![panel]);
        Ok(())
    }

    /// Puts no more panels side by side than have room, in boxes of about the same shape on a page of this share of its width.
    fn reflow(&mut self, share: f64) {
        let most = (self.width / self.sizes.least_width).max(1.0) as usize;
        let edges = self.sizes.top + self.sizes.bottom;
        let rows = std::mem::take(&mut self.rows).into_iter();
        let rows = rows.flat_map(|row| {
            let columns = row.columns.min(most);
            let share = share * row.columns as f64 / columns as f64;
            let inside = row.height - edges;
            let least = inside.min(LEAST_BOX_HEIGHT);
            let height = edges + (share.min(1.0) * inside).max(least);
            Row::of(height, columns, row.panels)
        });
        self.rows = rows.collect();
    }

    pub(crate) fn draw(&mut self) -> Drawing {
        self.share_labels();
        let (legend, (title, title_end)) = (self.legend_lines(), self.header());
        let header = match legend.len() {
            0 => title_end,
            lines => title_end + LEGEND_BELOW + (lines - 1) as f64 * LEGEND_LINE,
        };
        let panels_top = header + PANELS_BELOW;
        let rows_height = self
            .rows
            .iter()
            .map(|row| row.drawn(self.sizes))
            .sum::<f64>();
        let height = panels_top + rows_height + room_of(&self.x_label) + PAGE_EDGE;
        let mut drawing = Drawing::new(self.width, height);
        drawing.printed_m = self.printed_m;
        drawing.items.extend(title.into_iter().map(Item::Text));
        self.draw_legend(&mut drawing, &legend, title_end);
        let frames = self.place();
        self.draw_shared_labels(&mut drawing, &frames, panels_top, rows_height);
        self.draw_panels(&mut drawing, &frames, panels_top);
        drawing
    }

    /// Leaves a label that all panels of a row or column share to the outer one alone. If all panels
    /// share it and it is too long for one of them it goes to the page. Rows of unlike columns keep theirs.
    fn share_labels(&mut self) {
        (self.x_label, self.y_label) = (String::new(), String::new());
        let panels: Vec<&Panel> = self.rows.iter().flat_map(|row| &row.panels).collect();
        let Some((first, row)) = panels.first().zip(self.rows.first()) else {
            return;
        };
        let (columns, height) = (row.columns, row.height - self.sizes.bottom);
        let width = (self.width - 2.0 * PAGE_EDGE) / columns as f64;
        let of_all = |axis: fn(&Panel) -> &Axis, room: f64| {
            let label = &axis(first).label;
            let is_one = panels.len() > 1 && panels.iter().all(|panel| axis(panel).label == *label);
            let is_long = text_width(label, self.sizes.label) > room;
            (is_one && is_long).then(|| label.clone())
        };
        let x_label = of_all(|panel| &panel.x, width).unwrap_or_default();
        let y_label = of_all(|panel| &panel.y, height).unwrap_or_default();
        let is_even = self.rows.iter().all(|row| row.columns == columns);
        let tell = |axes: Vec<&mut Axis>, page: &str, outer: usize| {
            let shared = is_even && axes.windows(2).all(|pair| pair[0].label == pair[1].label);
            for (n, axis) in axes.into_iter().enumerate() {
                axis.is_redundant = !page.is_empty() || (shared && n != outer);
            }
        };
        for column in 0..columns {
            let panels = self.rows.iter_mut();
            let panels = panels.filter_map(|row| row.panels.get_mut(column));
            let axes: Vec<&mut Axis> = panels.map(|panel| &mut panel.x).collect();
            let last = axes.len().saturating_sub(1);
            tell(axes, &x_label, last);
        }
        for row in &mut self.rows {
            let axes = row.panels.iter_mut().map(|panel| &mut panel.y);
            tell(axes.collect(), &y_label, 0);
        }
        (self.x_label, self.y_label) = (x_label, y_label);
    }

    /// Fits all axes and finds the frame of each panel with its left edge on the page.
    fn place(&mut self) -> Vec<Vec<(f64, Frame)>> {
        let sizes = self.sizes;
        for row in &mut self.rows {
            for panel in &mut row.panels {
                panel.fit_y(row.height - sizes.bottom - sizes.top, sizes);
            }
        }
        let panels = self.rows.iter().flat_map(|row| &row.panels);
        let curves = panels.map(|panel| panel.curves.len()).sum::<usize>();
        let most_points = POINTS_OF_A_PAGE / curves.max(1);
        let page_left = PAGE_EDGE + room_of(&self.y_label);
        let lefts: Vec<Vec<f64>> = (self.rows.iter())
            .map(|row| self.margins_left(row.columns))
            .collect();
        let mut frames = Vec::new();
        for (row, lefts) in self.rows.iter_mut().zip(lefts) {
            let (height, bottom) = (row.drawn(sizes), row.height - sizes.bottom);
            let margins = lefts.iter().map(|left| left + sizes.right).sum::<f64>();
            let boxes = self.width - PAGE_EDGE - page_left - margins;
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
                    height,
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

    /// Space to the left of each box in rows of `columns` columns. Boxes stand in line: all columns
    /// with axis labels have one margin, and all without.
    fn margins_left(&self, columns: usize) -> Vec<f64> {
        let widest = |labelled: bool| {
            let panels = self.rows.iter().flat_map(|row| &row.panels);
            let panels = panels.filter(|panel| panel.y.own_label().is_empty() != labelled);
            let margins = panels.map(|panel| panel.margin_left(self.sizes));
            margins.fold(0.0, f64::max)
        };
        let (labelled, bare) = (widest(true), widest(false));
        let rows: Vec<&Row> = (self.rows.iter())
            .filter(|row| row.columns == columns)
            .collect();
        let has_label = |column: usize| {
            let mut panels = rows.iter().filter_map(|row| row.panels.get(column));
            panels.any(|panel| !panel.y.own_label().is_empty())
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
            end.unwrap_or(self.width) - start(&row[column])
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
            y += row.drawn(self.sizes);
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

    /// Title and subtitle in as many lines as they need, each in one size, and the last baseline.
    fn header(&self) -> (Vec<Text>, f64) {
        let left = 2.0 * PAGE_EDGE;
        let (mut texts, mut end, mut next) = (Vec::new(), 0.0, TITLE_BASELINE);
        let title = SMALLEST_TITLE_SIZE..=TITLE_SIZE;
        let subtitle = SMALLEST_SUBTITLE_SIZE..=SUBTITLE_SIZE;
        for (text, sizes, colour, below) in [
            (&self.title, title, INK, TITLE_LINE),
            (&self.subtitle, subtitle, MUTED_INK, SUBTITLE_LINE),
        ] {
            let lines = text.lines();
            let lines =
                lines.flat_map(|line| wrapped(line, sizes.clone(), self.width - 2.0 * left));
            let lines: Vec<_> = lines.collect();
            let size = lines.iter().map(|line| line.1).min();
            for (line, _) in lines {
                texts.push(Text {
                    colour,
                    ..Text::new(&line, left, next, size.unwrap_or_default())
                });
                (end, next) = (next, next + below);
            }
        }
        (texts, end)
    }

    /// One size for all names of the legend, at which the longest has room.
    fn legend_size(&self) -> u32 {
        let room = self.width - 4.0 * PAGE_EDGE - SAMPLE_LENGTH - SAMPLE_GAP;
        let names = self.legend.iter();
        names.fold(LABEL_SIZE, |size, entry| fit(&entry.name, size, room).1)
    }

    /// The entries of the legend in lines, each entry with its left edge.
    fn legend_lines(&self) -> Vec<Vec<(f64, &LegendEntry)>> {
        let (left, size) = (2.0 * PAGE_EDGE, self.legend_size());
        let mut lines: Vec<Vec<(f64, &LegendEntry)>> = Vec::new();
        let mut x = left;
        for entry in &self.legend {
            let width = SAMPLE_LENGTH + SAMPLE_GAP + text_width(&entry.name, size);
            if lines.is_empty() || x + width > self.width - left {
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

    fn draw_legend(
        &self,
        drawing: &mut Drawing,
        legend: &[Vec<(f64, &LegendEntry)>],
        title_end: f64,
    ) {
        let (left, size) = (2.0 * PAGE_EDGE, self.legend_size());
        for (line, entries) in legend.iter().enumerate() {
            let baseline = title_end + LEGEND_BELOW + line as f64 * LEGEND_LINE;
            for (x, entry) in entries {
                for form in &entry.forms {
                    let middle = baseline - 0.35 * f64::from(size);
                    drawing.items.append(&mut form.sample(*x, middle));
                }
                let x = x + SAMPLE_LENGTH + SAMPLE_GAP;
                let (name, size) = fit(&entry.name, size, self.width - left - x);
                drawing.text(Text::new(&name, x, baseline, size));
            }
        }
    }
}

/// Room for a label that all panels share.
const fn room_of(label: &str) -> f64 {
    if label.is_empty() { 0.0 } else { SHARED_LABEL }
}
