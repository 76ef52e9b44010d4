// Pairs of nodes in one cell's list whose boxes overlap, each once; pairs within one body only if it self-collides.
layout(std430, binding = 5) buffer NodePairs { uvec2 outNodePairs[]; }; // node, node not below it

uvec4 boxOf(uint node)
{
    return texelFetch(boxes, int(node) * BOXES_OF_NODE + BOXES_OF_NODE - 1);
}

void main()
{
    uint i = ITEM;
    if (i >= min(counters[entryCounter], entryCapacity))
        return;

    uvec4 entry = texelFetch(entries, int(i));
    uvec4 p = boxOf(entry.x);
    bool selfCollides = bodySelfCollides(entry.w);
    uint next = entry.y;
    while (next != none)
    {
        // Four at a time: where an implementation executes all branches, writing costs more than following the list.
        uvec4 found = uvec4(0u);
        uint count = 0u;
        while (next != none && count < 4u)
        {
            uvec4 other = texelFetch(entries, int(next)), q = boxOf(other.x);
            // Only in the first cell that both cover.
            bool isPair = OVERLAP(p, q) && cellAt(max(lowerEnds(p).xyz, lowerEnds(q).xyz) >> cellShift) == entry.z &&
                         (selfCollides || entry.w != other.w);
            found = isPair ? uvec4(other.x, found.xyz) : found;
            count += uint(isPair);
            next = other.y;
        }
        if (count != 0u)
        {
            uint at = append(nodePairCounter, count, nodePairCapacity);
            for (uint k = 0u; k < count; k++, found = found.yzwx)
                outNodePairs[min(at + k, nodePairCapacity)] = uvec2(min(entry.x, found.x), max(entry.x, found.x));
            if (at >= 0x80000000u)
                counters[overflowCounter] = 1u; // before the counter wraps around
        }
    }
    if (next != none)
        counters[stoppedCounter] = 1u;
}
