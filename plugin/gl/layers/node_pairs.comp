// Pairs of nodes in one pixel's list whose intervals overlap, each once, as the rules of their bodies let them.
layout(std430, binding = 1) buffer NodePairs { uvec4 outNodePairs[]; }; // node, node not below it, table or none
uniform uint entryCapacity, nodePairCapacity, pixelShift, columnShift;

const uint isMoving = 1u, meetsItself = 2u;

bool mayMeet(uint a, uint b)
{
    uvec4 p = texelFetch(bodies, int(a) * BODY_TEXELS), q = texelFetch(bodies, int(b) * BODY_TEXELS); // group, mask, flags
    return a == b ? (p.z & meetsItself) != 0u
                  : ((p.z | q.z) & isMoving) != 0u && (p.x & q.y) != 0u && (q.x & p.y) != 0u;
}

void main()
{
    uint i = ITEM;
    if (i >= countOf(entryCounter, entryCapacity))
        return;

    uvec4 entry = texelFetch(entries, int(i));
    uvec4 p = texelFetch(nodeBoxes, int(entry.x));
    uint next = i;
    bool stopped = false; // some implementations do it, after 65 535 trips of both loops
    while (next != none)
    {
        uvec2 other = texelFetch(entries, int(next)).xy;
        next = other.y;
        uvec4 q = texelFetch(nodeBoxes, int(other.x));
        // In the first pixel that both cover, and in no other.
        uvec2 first = max(lowerEnds(p).xy, lowerEnds(q).xy) >> pixelShift;
        if (OVERLAP(p, q) && (first.y << columnShift | first.x) == entry.z)
        {
            uint a = min(entry.x, other.x), b = max(entry.x, other.x);
            uvec4 node = texelFetch(nodes, int(a)); // body, first link, end of links
            if (mayMeet(node.x, texelFetch(nodes, int(b)).x))
            {
                uint table = none, k = node.y;
                for (; k < node.z; k++)
                {
                    uvec2 link = texelFetch(links, int(k)).xy;
                    table = link.x == b ? link.y : table;
                }
                stopped = stopped || k < node.z;
                uint place = append(nodePairCounter, 1u, nodePairCapacity);
                if (place < nodePairCapacity)
                    outNodePairs[place] = uvec4(a, b, table, 0u);
                else if (place >= 0x80000000u)
                    counters[overflowCounter] = 1u; // before it starts again from zero
            }
        }
    }
    if (stopped || next != none)
        counters[stoppedCounter] = 1u;
}
