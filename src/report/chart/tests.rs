use super::*;

fn named(name: &str) -> Option<String> {
    Some(name.to_string())
}

fn points(name: &str, points: &[(f64, f64)]) -> Layer {
    let points = points.iter().map(|(x, y)| ChartPoint::at(*x, *y));
    Layer::points(named(name), points.collect(), Style::group(1))
}

fn chart(layers: Vec<Layer>) -> Chart {
    Chart::new(Axis::new("x"), Axis::new("y"), layers)
}

fn size(width: f64, height: f64) -> Extent {
    Extent { width, height }
}

fn line(xy: Vec<(f64, f64)>) -> Layer {
    Layer {
        name: None,
        ..Layer::curve("", xy, Style::group(2), Dash::Dashed)
    }
}

fn assert_well_formed(document: &str) {
    if let Err(error) = roxmltree::Document::parse(document) {
        panic!("{error}: {document}");
    }
}

fn count(document: &str, part: &str) -> usize {
    document.matches(part).count()
}

fn assert_finite(document: &str) {
    assert!(!document.contains("NaN") && !document.contains("inf"), "{document}");
}

#[test]
fn hostile_text_is_escaped() {
    let mut c = chart(vec![points("n <&> \"'$x$\u{1}\u{FFFF}", &[(1.0, 2.0)])]);
    c.title = named("t <&>");
    c.x = Axis::new("x_{<&>}");
    c.y = Axis::new("y^{</text>");
    let document = svg(&[c]);
    assert_well_formed(&document);
    assert!(document.contains("t &lt;&amp;&gt;"));
    assert!(document.contains("n &lt;&amp;&gt; &quot;&apos;$x$  "));
    assert!(document.contains("&lt;&amp;&gt;</tspan>"));
}

#[test]
fn every_name_stands_in_the_legend_once() {
    let layers = vec![
        points("AK_10", &[(1.0, 2.0)]),
        Layer::curve("fit", vec![(0.0, 0.0), (1.0, 1.0)], Style::group(1), Dash::Solid),
        Layer::band("spread", vec![(0.0, 0.0, 1.0), (1.0, 1.0, 2.0)], Style::group(1)),
        points("nothing to show", &[]),
        line(vec![(0.0, 0.0), (1.0, 1.0)]),
    ];
    let both = [chart(layers.clone()), chart(layers)];
    for charts in [&both[..1], &both[..]] {
        let document = svg(charts);
        for name in ["AK_10", "fit", "spread", "nothing to show"] {
            assert_eq!(count(&document, &format!(">{name}</text>")), 1, "{name}");
        }
        assert_well_formed(&document);
    }
}

#[test]
fn values_that_are_not_finite_are_left_out() {
    let nan = f64::NAN;
    let good = [(1.0, 2.0), (2.0, 3.0)];
    let odd = [(nan, 1.0), (1.0, f64::INFINITY), (-f64::MAX, 0.0)];
    let drawn = |xy: &[(f64, f64)]| svg(&[chart(vec![points("A", xy)])]);
    assert_eq!(drawn(&good), drawn(&[&good[..], &odd].concat()));
    let with_bar = |y_se| {
        let point = ChartPoint {
            y_se,
            ..ChartPoint::at(1.0, 2.0)
        };
        svg(&[chart(vec![Layer::points(None, vec![point], Style::group(1))])])
    };
    for se in [nan, f64::INFINITY, -1.0, 0.0] {
        assert_eq!(with_bar(Some(se)), with_bar(None));
    }
    assert_ne!(with_bar(Some(0.5)), with_bar(None));

    let broken = vec![(0.0, 0.0), (1.0, 1.0), (2.0, nan), (3.0, 1.0), (4.0, 0.0)];
    let document = svg(&[chart(vec![line(broken)])]);
    assert_eq!(count(&document, "stroke-dasharray"), 2, "gap is not bridged");
    assert_finite(&document);
}

#[test]
fn degenerate_charts_are_drawn() {
    let nan = f64::NAN;
    let layers: Vec<Vec<Layer>> = vec![
        vec![],
        vec![points("A", &[])],
        vec![points("A", &[(2.0, 0.5)])],
        vec![points("A", &[(0.0, 0.0), (0.0, 0.0)])],
        vec![points("A", &[(nan, nan)])],
        vec![points("A", &[(1e300, -1e300), (1e99, -1e99)])],
        vec![points("A", &[(1e-320, 1.0), (0.0, 1.0 + f64::EPSILON)])],
        vec![line(vec![]), line(vec![(1.0, 1.0)])],
        vec![line(vec![(0.0, nan), (1.0, 1e300), (2.0, -1.0)])],
        vec![Layer {
            name: None,
            style: Style::group(99),
            marks: Marks::Band(vec![(nan, 0.0, 1.0), (0.0, 0.0, f64::INFINITY), (1.0, 0.0, 1.0)]),
        }],
    ];
    for layers in layers {
        let mut c = chart(layers);
        let fitted = svg(&[c.clone()]);
        for range in [(1.0, 1.0), (2.0, 1.0), (nan, 2.0), (0.0, f64::INFINITY), (0.0, 1e-90)] {
            c.y.range = Some(range);
            assert!(
                range == (0.0, 1e-90) || svg(&[c.clone()]) == fitted,
                "limits that span nothing"
            );
            let both = [c.clone(), c.clone()];
            let row = [both.to_vec()];
            for document in [svg(&both[..1]), svg(&both), grid(&row, size(90.0, 90.0))] {
                assert_well_formed(&document);
                assert_finite(&document);
            }
        }
    }
    assert_well_formed(&svg(&[]));
    assert_well_formed(&grid(&[vec![]], size(90.0, 90.0)));
}

#[test]
fn groups_differ_in_more_than_colour() {
    let drawn: Vec<String> = (0..16)
        .map(|group| {
            let layer = Layer::points(None, vec![ChartPoint::at(1.0, 1.0)], Style::group(group));
            let document = svg(&[chart(vec![layer])]);
            // Keeps fillings apart while hiding the colours.
            let grey: Vec<&str> = document
                .split(['"', '<'])
                .map(|p| match p {
                    "#ffffff" => "white",
                    p if p.starts_with('#') => "dark",
                    p => p,
                })
                .collect();
            grey.concat()
        })
        .collect();
    for (i, a) in drawn.iter().enumerate() {
        assert!(drawn[..i].iter().all(|b| a != b), "group {i} repeats another");
    }
}

/// Width of the whole picture.
fn width(document: &str) -> f64 {
    let from = document.find(" width=\"").expect("width") + 8;
    let number = document[from..].split('"').next().expect("quoted");
    number.parse().expect("number")
}

#[test]
fn long_text_widens_the_picture() {
    let long = "a name that is too long for the page ".repeat(5);
    assert_eq!(width(&svg(&[chart(vec![points("A", &[])])])), 720.0);
    assert!(width(&svg(&[chart(vec![points(&long, &[])])])) > 1000.0);
    let mut titled = chart(vec![]);
    titled.title = named(&long);
    assert!(width(&svg(&[titled])) > 1000.0);
}

#[test]
fn a_grid_draws_dots_and_only_the_axes_that_have_a_label() {
    let cloud = |label: &str| Chart {
        title: None,
        x: Axis::new(label).between(0.0, 1.0),
        y: Axis::new("").between(0.0, 1.0),
        layers: vec![points("A", &[(0.2, 0.3), (0.4, 0.5), (7.0, 0.5)])],
    };
    let rows = vec![vec![cloud("")], vec![cloud("x <&>"), cloud("z")]];
    let document = grid(&rows, size(100.0, 80.0));
    assert_well_formed(&document);
    assert_eq!(
        count(&document, "h2v2h-2z"),
        6,
        "two of three points lie inside each panel"
    );
    assert_eq!(count(&document, ">0.5</text>"), 2, "ticks of the two labelled axes");
    assert_eq!(count(&document, ">A</text>"), 1, "one legend");
}
