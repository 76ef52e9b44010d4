// Pairs of nodes in one cell's list whose intervals overlap, each once; not of one body that does not meet itself.
layout(std430, binding = 1) buffer NodePairs { uvec2 outNodePairs[]; }; // node, node not below it
uniform uint entryCapacity, nodePairCapacity;

void main()
{
    uint i = ITEM;
    if (i >= countOf(entryCounter, entryCapacity))
        return;

    uvec4 entry = texelFetch(entries, int(i));
    uvec4 p = texelFetch(nodeBoxes, int(entry.x));
    bool meetsItself = bodyMeetsItself(entry.w);
    uint next = entry.y;
    while (next != none)
    {
        // Four at a time: where an implementation takes all branches, writing costs more than walking.
        uvec4 met = uvec4(0u);
        uint count = 0u;
        while (next != none && count < 4u)
        {
            uvec4 other = texelFetch(entries, int(next)), q = texelFetch(nodeBoxes, int(other.x));
            // In the first cell that both cover, and in no other.
            bool meets = OVERLAP(p, q) && cellAt(max(lowerEnds(p).xyz, lowerEnds(q).xyz) >> cellShift) == entry.z &&
                         (meetsItself || entry.w != other.w);
            met = meets ? uvec4(other.x, met.xyz) : met;
            count += uint(meets);
            next = other.y;
        }
        if (count != 0u)
        {
            uint place = append(nodePairCounter, count, nodePairCapacity);
            for (uint k = 0u; k < count; k++, met = met.yzwx)
                outNodePairs[min(place + k, nodePairCapacity)] =
                    uvec2(min(entry.x, met.x), max(entry.x, met.x));
            if (place >= 0x80000000u)
                counters[overflowCounter] = 1u; // before it starts again from zero
        }
    }
    if (next != none)
        counters[stoppedCounter] = 1u;
}
