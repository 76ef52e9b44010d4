// Boxes of nodes, and the image: each node goes into the list of every pixel that its box covers.
layout(std430, binding = 1) buffer NodeBoxes { uvec4 outNodeBoxes[]; };
layout(std430, binding = 2) buffer Heads { uint heads[]; };
layout(std430, binding = 3) buffer Entries { uvec4 outEntries[]; }; // node, next entry, pixel
uniform uint nodeCount, pixelShift, columnShift, entryCapacity;

void main()
{
    uint i = ITEM;
    if (i >= nodeCount)
        return;

    int node = int(texelFetch(activeNodes, int(i)).x);
    uvec4 lower = uvec4(0x7fffu), upper = uvec4(0u);
    for (int k = 0; k < 8; k++)
    {
        uvec4 box = texelFetch(clusterBoxes, node * 8 + k);
        lower = min(lower, lowerEnds(box));
        upper = max(upper, upperEnds(box));
    }
    uvec4 box = packBox(lower, upper);
    outNodeBoxes[node] = box;
    // Only what lies where its body can meet another takes part.
    uvec4 interest = texelFetch(bodies, int(texelFetch(nodes, node).x) * BODY_TEXELS + 1);
    if (OVERLAP(box, interest))
    {
        uvec2 first = lower.xy >> pixelShift, last = upper.xy >> pixelShift, size = last - first + 1u;
        uint place = append(entryCounter, size.x * size.y, entryCapacity), end = place + size.x * size.y;
        for (uint y = first.y; y <= last.y; y++)
            for (uint x = first.x; x <= last.x; x++, place++)
                if (place < entryCapacity)
                {
                    uint pixel = y << columnShift | x, next = atomicExchange(heads[pixel], place);
                    outEntries[place] = uvec4(uint(node), next, pixel, 0u);
                }
                else if (place >= 0x80000000u)
                    counters[overflowCounter] = 1u;
        // Some implementations stop the loops of an invocation after 65 535 trips in all.
        if (place != end)
            counters[stoppedCounter] = 1u;
    }
    else
        atomicAdd(counters[skippedCounter], 1u);
}
