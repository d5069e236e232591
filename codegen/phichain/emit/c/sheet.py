"""What the body of a C function is written on: its lines, its variables and arrays, how operands are spelt."""

from __future__ import annotations

from collections import Counter

from phichain.emit.c.handed_on import handed_on
from phichain.emit.c.layout import laid_out
from phichain.emit.c.names import SIDE_BY_SIDE, CNames
from phichain.emit.c.parts import names_in
from phichain.emit.c.storage import Storage, own_storage, shared_storage
from phichain.emit.c.turns import Key, key
from phichain.emit.expressions import Text
from phichain.ir.nodes import Array, Call, Cell, Const, Local, Operand, Program, SinCos, walk


def work_field(program: Program, array: Array) -> str:
    """What an array of a Program is called in a workspace that it shares with others."""
    return f"{program.name}_{array.name}"


class Sheet:
    """The lines of one Program's function, the names in it and the texts of its values."""

    def __init__(
        self, program: Program, names: CNames, callees: dict[str, str], working: frozenset[str] = frozenset()
    ) -> None:
        self.program, self.names, self.callees, self.working = program, names, callees, working
        #: C type of what the inputs determine.
        self.element = names.type
        self.lines: list[str] = []
        self.wants_gap = False
        self.uses: set[str] = set()
        self.texts: dict[str, Text] = {}
        self.storage = self.stored_in()
        #: Of arrays of sines and cosines that stand side by side, the array of pairs and which part of each.
        self.pairs = self.side_by_side_arrays()
        #: Work arrays of one cell, which are variables: whoever wants an array is given their address.
        self.single = {a.name for a in program.work if a.size == 1}
        self.scalars = {a.name for a in (*program.inputs, *program.params) if a.shape == ()} | self.single
        self.pointers = {a.name for a in program.outputs if a.shape == ()}
        self.params = {a.name for a in program.params}
        self.taken = names_in(program)
        #: Arrays of which one row is enough.
        self.handed = handed_on(program)
        self.records = "link" if "link" not in self.taken else "links"
        self.record_type = f"{program.name}_{self.records}"
        self.numbers: Counter[str] = Counter()
        #: How what changes is declared that compilers may keep in a register; nothing where a host's vectors are written for.
        self.register = names.register
        #: Of the loops that are being written: pointers and the offsets where they point, and cells that stand in variables.
        self.rows_at: dict[Key, tuple[str, int]] = {}
        self.cells_at: dict[Cell, Text] = {}

    # --- lines ------------------------------------------------------------------------------------------------------

    def line(self, depth: int, text: str) -> None:
        if self.wants_gap and self.lines:
            self.lines.append("")
        self.wants_gap = False
        self.lines += laid_out("    " * depth + text)

    def gap(self, depth: int) -> None:
        """A blank line before what comes next, between the parts of a function."""
        self.wants_gap = self.wants_gap or depth == 1

    def kind(self, value: str) -> str:
        """C type of a result, a carried scalar or an array's elements."""
        return self.element

    def given(self, value: str, operand: Operand) -> str:
        """An operand as what the named value is set to."""
        return self.operand(operand).text

    def variable(self, depth: int, name: str, text: str, kind: str) -> Text:
        """A `const` variable."""
        self.line(depth, f"{self.names.value if kind == self.names.type else f'const {kind}'} {name} = {text};")
        return Text(name)

    def fresh(self, stem: str) -> str:
        """The stem with the next number that nothing in this function is called by."""
        while True:
            self.numbers[stem] += 1
            name = f"{stem}{self.numbers[stem]}"
            if name not in self.taken:
                return name

    # --- arrays -----------------------------------------------------------------------------------------------------

    def stored_in(self) -> Storage:
        """Where work arrays stand: side by side for a host's vectors, else one after another in the same cells."""
        return shared_storage(self.program, self.names.has_pairs) if self.names.is_plain and not self.working else own_storage(self.program)

    def side_by_side_arrays(self) -> dict[str, tuple[str, int]]:
        """Sines and cosines that one array of pairs holds: work arrays of this function alone, in no other's cells."""
        turned = [statement for statement in walk(self.program.body) if isinstance(statement, SinCos)]
        both = list(dict.fromkeys((statement.sine, statement.cosine) for statement in turned))
        apart = {array.name for array in self.program.work if array.size == 1}
        apart |= {name for pair in self.storage.guests.items() for name in pair} | set(self.storage.fields)
        apart |= {name for s in walk(self.program.body) if isinstance(s, Call) for name in (*s.inputs, *s.outputs)}
        sizes = {array.name: array.size for array in self.program.work if array.name not in apart}
        named = [name for pair in both for name in pair]
        if not self.names.has_pairs or self.program.name in self.working or len(set(named)) < len(named):
            return {}
        found = [pair for pair in both if set(pair) <= set(sizes) and sizes[pair[0]] == sizes[pair[1]]]
        stems = [f"{SIDE_BY_SIDE}_{number}" if number > 1 else SIDE_BY_SIDE for number in range(1, len(found) + 1)]
        return {name: (stem, part) for stem, pair in zip(stems, found, strict=True) for part, name in enumerate(pair)}

    def arrays(self) -> None:
        fields, guests = self.storage.fields, self.storage.guests
        for array in self.program.work:
            kind, size = self.kind(array.name), self.storage.sizes.get(array.name)
            if array.name in self.pairs:
                pairs, part = self.pairs[array.name]
                if part == 0:
                    self.line(1, f"{kind} {pairs}[{array.size}][2];")
            elif self.program.name in self.working and array.size > 1:
                self.line(1, f"{kind} *const {array.name} = work->{work_field(self.program, array)};")
            elif size is not None and array.name not in fields:
                size = self.handed[array.name].lanes if array.name in self.handed else size
                self.line(1, f"{kind} {array.name}{'' if size == 1 else f'[{size}]'};")
        if fields:
            self.line(1, '/* What a name says after "then" stands there once what it says before has served. */')
            self.line(1, f"struct {self.record_type} {{")
            for name in dict.fromkeys(fields.values()):
                self.line(2, f"{self.element} {name};")
            self.line(1, f"}} {self.records}[{self.storage.extent}];")
        apart = {name: place for name, place in guests.items() if name not in fields}
        if apart:
            self.line(1, "/* In the cells of arrays that have served: */")
        for name, place in apart.items():
            self.line(1, f"{self.kind(name)} *const {name} = {place};")
        self.gap(1)

    # --- operands ---------------------------------------------------------------------------------------------------

    def operand(self, operand: Operand) -> Text:
        if isinstance(operand, Const):
            return self.names.number(operand.value)
        if isinstance(operand, Local):
            return self.texts[operand.name]
        return self.cells_at.get(operand) or Text(self.target(operand))

    def named_after(self, cell: Cell) -> str:
        """What a variable that holds a cell's value is called after."""
        return self.storage.fields.get(cell.array, cell.array).split("_then_")[0]

    def target(self, cell: Cell) -> str:
        if cell.array in self.pointers:
            return f"*{cell.array}"
        if cell.array in self.handed:
            return f"{cell.array}[{self.handed[cell.array].cell(cell.index)}]"
        if cell.array in self.pairs:
            pairs, part = self.pairs[cell.array]
            return f"{pairs}[{cell.index}][{part}]"
        if cell.array in self.storage.fields:
            at = self.rows_at.get(key(cell, self.storage.fields))
            return f"{f'{at[0]}->' if at else f'{self.records}[{cell.index}].'}{self.storage.fields[cell.array]}"
        if row := self.rows_at.get(key(cell, ())):
            return f"{row[0]}[{cell.index.offset - row[1]}]"
        owner = f"p->{cell.array}" if cell.array in self.params else cell.array
        if cell.array in self.program.tables:
            owner = self.names.tables[cell.array, self.program.tables[cell.array]]
        return owner if cell.array in self.scalars else f"{owner}[{cell.index}]"

    def argument(self, name: str) -> str:
        if name in self.single:
            return f"&{name}"
        return f"p->{name}" if name in self.params else name
