// Many cells of a column at once, which rubbl_casatables does not offer.
//
// A function returns 0 if all went well; 1 if the cells are not all there, of the type and of the shape
// wanted, which whoever asks may look into cell by cell; 2 if casacore threw, with its words in `error`.

#include <casacore/tables/Tables.h>
#include <casacore/tables/Tables/TableAttr.h>

#include <cstdint>
#include <cstring>
#include <exception>
#include <new>

using namespace casacore;

namespace {

const int FINE = 0, IRREGULAR = 1, FAILED = 2;

// Runs `body`; whatever it throws becomes words.
template <class F>
int guarded(char *error, size_t error_len, F body)
{
    const char *what = "unknown exception";
    try {
        return body();
    } catch (const std::exception &e) {
        what = e.what();
        std::strncpy(error, what, error_len - 1);
        error[error_len - 1] = '\0';
    } catch (...) {
        std::strncpy(error, what, error_len - 1);
        error[error_len - 1] = '\0';
    }
    return FAILED;
}

// Whether all cells have the shape wanted.
template <class T>
bool is_regular(const ArrayColumn<T> &column, uint64_t row, uint64_t n_row, const IPosition &shape)
{
    if (column.columnDesc().isFixedShape()) {
        return column.shapeColumn().isEqual(shape);
    }
    for (uint64_t i = row; i < row + n_row; ++i) {
        if (!column.isDefined(i) || !column.shape(i).isEqual(shape)) {
            return false;
        }
    }
    return true;
}

template <class T>
int read(const Table &table, const String &name, uint64_t row, uint64_t n_row, const IPosition &shape,
         void *out)
{
    const ColumnDesc &description = table.tableDesc().columnDesc(name);
    if (description.dataType() != whatType(static_cast<T *>(nullptr)) || description.isScalar() != (shape.nelements() == 0)) {
        return IRREGULAR;
    }
    T *values = static_cast<T *>(out);
    const Slicer rows(IPosition(1, row), IPosition(1, n_row));
    if (shape.nelements() == 0) {
        Vector<T> vector(IPosition(1, n_row), values, SHARE);
        ScalarColumn<T>(table, name).getColumnRange(rows, vector, False);
        return FINE;
    }
    const ArrayColumn<T> column(table, name);
    if (!is_regular(column, row, n_row, shape)) {
        return IRREGULAR;
    }
    IPosition all(shape);
    all.append(IPosition(1, n_row));
    Array<T> array(all, values, SHARE);
    column.getColumnRange(rows, array, False);
    // An array that was made anew would leave `out` as it was.
    return array.data() == values ? FINE : IRREGULAR;
}

// What is thrown again where casacore throws again what nobody has thrown.
struct Nothing : std::exception {
    const char *what() const noexcept override
    {
        return "a column is of a class that casacore does not know";
    }
};

}  // namespace

extern "C" {

// Opens a table; null if casacore threw.
//
// For a column of a class that is unknown, casacore has a bare `throw` (ColumnDesc::getCtor), which ends the
// process unless an exception is being handled.
void *vis2cat_table_open(const char *path, char *error, size_t error_len)
{
    void *table = nullptr;
    guarded(error, error_len, [&] {
        try {
            throw Nothing();
        } catch (const Nothing &) {
            table = new Table(String(path), Table::Old);
        }
        return FINE;
    });
    return table;
}

void vis2cat_table_close(void *table)
{
    try {
        delete static_cast<Table *>(table);
    } catch (...) {
        // It was only read.
    }
}

// Writes where the table is that the keyword `name` names.
int vis2cat_table_named(const void *table, const char *name, char *path, char *error, size_t len)
{
    return guarded(error, len, [&]() -> int {
        const TableRecord &keywords = static_cast<const Table *>(table)->keywordSet();
        const Int field = keywords.fieldNumber(name);
        if (field < 0 || keywords.dataType(field) != TpTable) {
            return IRREGULAR;
        }
        const String found = keywords.tableAttributes(field).name();
        if (found.length() >= len) {
            return IRREGULAR;
        }
        std::memcpy(path, found.c_str(), found.length() + 1);
        return FINE;
    });
}

// Reads the cells `row` to `row + n_row` of a column into `out`. `axes` has the shape of a cell, fastest
// axis first; a scalar has none. `type` is casacore's number of it.
int vis2cat_table_range(const void *table, const char *column, int type, uint64_t row, uint64_t n_row,
                        const uint64_t *axes, size_t n_axis, void *out, char *error, size_t error_len)
{
    return guarded(error, error_len, [&]() -> int {
        const Table &from = *static_cast<const Table *>(table);
        if (row + n_row < row || row + n_row > from.nrow()) {
            return IRREGULAR;
        }
        IPosition shape(n_axis);
        for (size_t i = 0; i < n_axis; ++i) {
            shape[i] = axes[i];
        }
        const String name(column);
        switch (type) {
        case TpBool:
            return read<Bool>(from, name, row, n_row, shape, out);
        case TpInt:
            return read<Int>(from, name, row, n_row, shape, out);
        case TpFloat:
            return read<Float>(from, name, row, n_row, shape, out);
        case TpDouble:
            return read<Double>(from, name, row, n_row, shape, out);
        case TpComplex:
            return read<Complex>(from, name, row, n_row, shape, out);
        default:
            return IRREGULAR;
        }
    });
}

}
