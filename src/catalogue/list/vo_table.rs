//! A list of sources as VOTable: what TOPCAT and the services of the Virtual Observatory write.

use std::path::Path;

use roxmltree::{Document, Node};
use vis2cat_formats::ReadError;

use super::cells::CellTable;
use super::malformed;

/// The cells of the first table of a file, which must be TABLEDATA.
///
/// # Source
/// IVOA, "VOTable Format Definition" 1.5, sections 4 and 5.1.
pub(super) fn read(path: &Path) -> Result<CellTable, ReadError> {
    let text = std::fs::read_to_string(path).map_err(|source| ReadError::Io {
        path: path.into(),
        source,
    })?;
    let wrong = |what: &str| malformed(path, "VOTable".to_owned(), what);
    let document = Document::parse(&text).map_err(|e| wrong(&e.to_string()))?;
    // The namespace depends on the version.
    let find = |node: Node<'_, '_>, name: &str| {
        let mut below = node.descendants();
        below
            .find(|node| node.tag_name().name() == name)
            .map(|node| node.id())
    };
    let first = |node, name: &str| find(node, name).and_then(|id| document.get_node(id));
    let table = first(document.root(), "TABLE").ok_or_else(|| wrong("there is no TABLE in it"))?;
    let fields = children(table, "FIELD");
    let attribute = |field: Node<'_, '_>, name: &str| field.attribute(name).map(str::to_owned);
    let columns = fields.map(|field| {
        let name = attribute(field, "name").unwrap_or_default();
        (name, attribute(field, "unit"))
    });
    let rows = match (first(table, "TABLEDATA"), first(table, "DATA")) {
        (Some(data), _) => children(data, "TR").map(cells).collect(),
        (None, None) => Vec::new(),
        (None, Some(_)) => {
            return Err(wrong(
                "its data are no TABLEDATA; convert it, as with \
                 stilts tpipe in=FILE ofmt=votable-tabledata out=table.vot",
            ));
        }
    };
    Ok(CellTable {
        path: path.into(),
        columns: columns.collect(),
        rows,
    })
}

fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    let children = node.children();
    children.filter(move |child| child.tag_name().name() == name)
}

/// The texts of a row.
fn cells(row: Node<'_, '_>) -> Vec<String> {
    let cell = |cell: Node<'_, '_>| cell.text().unwrap_or_default().trim().to_owned();
    row.children().filter(Node::is_element).map(cell).collect()
}
