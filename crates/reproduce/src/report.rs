//! The report: Markdown, and the same as one self-contained HTML file.

use super::claims::Claim;
use super::evidence::Evidence;
use std::fmt::Write as _;

/// A figure as the report shows it.
#[derive(Clone, Debug)]
pub struct ReportFigure {
    /// The number that the dissertation gives it.
    pub id: &'static str,
    /// Content of the figure, as its title.
    pub title: &'static str,
    /// Parameters, shown below the picture.
    pub conditions: String,
    /// File name of the picture, beside the report.
    pub picture: String,
    /// File name of the data.
    pub data: String,
    /// The drawing, which the HTML report holds itself.
    pub svg: String,
}

const INTRODUCTION: &str = "The figures of O. Tokatlı, *Fractional Order Control in Haptics* (PhD dissertation, Sabancı University, \
    2015), made again, and its claims judged by computing, each with the operator of its chapter: (1 − w)^μ in 3 and 5, the \
    third-order Muir polynomial A₃ in 4, s^μ in 1 and 6, in 7 one that is fitted over frequencies, for which Oustaloup's stands here. \
    Where that is not (1 − w)^μ, the same is computed with (1 − w)^μ beside it. Verdicts follow from the numbers beside them. Not \
    compared are the dissertation's pictures, of which only the text was at hand, and its measurements, on its device and on \
    prostate: a simulated device and the closed form stand in their place, and beside figure 7.2 a tissue whose record is published.";

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}\
    table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.4em .6em;text-align:left;vertical-align:top}\
    th{background:#f4f4f4}svg{max-width:100%;height:auto}.holds{color:#00664d}.not{color:#a03c00}";

const COLUMNS: [&str; 5] = [
    "id",
    "section",
    "the dissertation says",
    "verdict",
    "numbers",
];

/// A claim in these columns, fit for the page.
fn cells(claim: &Claim, fit: impl Fn(&str) -> String) -> [String; 5] {
    let evidence = |one: &Evidence| {
        let holds = match one.holds {
            Some(true) => "yes",
            Some(false) => "no",
            None => "not judged",
        };
        format!("{}: {holds}; {}", one.operator, fit(&one.numbers))
    };
    let evidence: Vec<String> = claim.evidence.iter().map(evidence).collect();
    [
        claim.id.to_owned(),
        claim.section.to_owned(),
        fit(claim.statement),
        claim.verdict.clone(),
        evidence.join("<br>"),
    ]
}

/// The report in Markdown, pictures by file name.
#[must_use]
pub fn markdown(claims: &[Claim], figures: &[ReportFigure]) -> String {
    let mut text = format!(
        "# The dissertation, made again\n\n{INTRODUCTION}\n\n## Claims\n\n| {} |\n|---|---|---|---|---|\n",
        COLUMNS.join(" | ")
    );
    for claim in claims {
        // A pipe would end the cell. Writing to a string cannot fail.
        let mut cells = cells(claim, |text| text.replace('|', "\\|"));
        cells[3] = format!("**{}**", cells[3]);
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text.push_str("\n## Figures\n");
    for figure in figures {
        let _ = writeln!(
            text,
            "\n### Figure {0}: {1}\n\nData: [{2}]({2}).\n\n![Figure {0}]({3})\n\n{4}.",
            figure.id,
            figure.title,
            figure.data,
            figure.picture,
            one_line(&figure.conditions)
        );
    }
    text
}

/// The report as one HTML file that needs no other.
#[must_use]
pub fn html(claims: &[Claim], figures: &[ReportFigure]) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>The dissertation, made again</title><style>{STYLE}</style></head><body>\n\
         <h1>The dissertation, made again</h1>\n<p>{}</p>\n<h2>Claims</h2>\n<table><tr><th>{}</th></tr>\n",
        escape(&INTRODUCTION.replace('*', "")),
        COLUMNS.join("</th><th>")
    );
    for claim in claims {
        let class = if claim.verdict == "holds" {
            "holds"
        } else {
            "not"
        };
        let [id, section, statement, verdict, evidence] = cells(claim, escape);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "<tr><td>{id}</td><td>{section}</td><td>{statement}</td><td class=\"{class}\"><b>{verdict}</b></td>\
             <td>{evidence}</td></tr>"
        );
    }
    text.push_str("</table>\n<h2>Figures</h2>\n");
    for figure in figures {
        let _ = writeln!(
            text,
            "<h3 id=\"figure-{0}\">Figure {0}: {1}</h3>\n<p>{2}. Data: <a href=\"{3}\">{3}</a></p>\n{4}",
            figure.id,
            escape(figure.title),
            escape(&one_line(&figure.conditions)),
            escape(&figure.data),
            // Identifiers in the drawings would meet on one page.
            own_ids(&figure.svg, figure.id)
        );
    }
    text.push_str("</body></html>\n");
    text
}

/// A text that the picture has on several lines.
fn one_line(text: &str) -> String {
    text.replace('\n', "; ")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// Gives the identifiers of a drawing a prefix of their own.
fn own_ids(svg: &str, id: &str) -> String {
    let prefix = format!("f{}-", id.replace('.', "-"));
    svg.replace("id=\"", &format!("id=\"{prefix}"))
        .replace("url(#", &format!("url(#{prefix}"))
        .replace("href=\"#", &format!("href=\"#{prefix}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_names_every_claim_and_figure_and_escapes_what_it_must() {
        let evidence = |operator, holds, numbers: &str| Evidence {
            operator,
            holds: Some(holds),
            numbers: numbers.to_owned(),
        };
        let claims = [Claim {
            id: "C1",
            statement: "a < b",
            section: "4.3",
            verdict: "holds only with (1 − w)^μ".to_owned(),
            evidence: vec![
                evidence("A₃", false, "|S| = 1"),
                evidence("(1 − w)^μ", true, "2 & 3"),
            ],
        }];
        let figures = [ReportFigure {
            id: "4.1",
            title: "walls",
            conditions: "δ = 0\nno hand".to_owned(),
            picture: "figure-4.1.png".to_owned(),
            data: "figure-4.1.csv".to_owned(),
            svg: "<svg><path id=\"c\" clip-path=\"url(#c)\"/></svg>".to_owned(),
        }];
        let markdown = markdown(&claims, &figures);
        assert!(markdown.contains("| C1 | 4.3 | a < b | **holds only with (1 − w)^μ** |"));
        assert!(markdown.contains("\\|S\\| = 1"));
        assert!(markdown.contains("![Figure 4.1](figure-4.1.png)"));
        assert!(markdown.contains("\nδ = 0; no hand.\n"));
        let html = html(&claims, &figures);
        assert!(html.contains("a &lt; b") && html.contains("2 &amp; 3"));
        assert!(html.contains("id=\"f4-1-c\" clip-path=\"url(#f4-1-c)\""));
        assert!(!html.contains("src="), "self-contained");
    }
}
