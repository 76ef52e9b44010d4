// For the image only: boxes of nodes, and the image. Each node is added to the list of every cell that its box covers.
layout(std430, binding = 4) buffer Entries { uvec4 outEntries[]; }; // node, next entry, cell, body
layout(std430, binding = 6) buffer NodeBoxes { uint outNodeBoxes[]; }; // from word groupsAt on: groups of clusters

void main()
{
    if (ITEM == 0u)
        counters[finishedCounter] = runNumber;
    uint i = ITEM;
    if (i >= activeNodes)
        return;

    int node = int(activeNode(i));
    uvec4 lower = uvec4(highestLevel), upper = uvec4(0u);
    for (int k = 0; k < 8; k += 2)
    {
        uvec4 first = texelFetch(clusterBoxes, node * 8 + k), second = texelFetch(clusterBoxes, node * 8 + k + 1);
        uvec4 lowers[] = uvec4[](lowerEnds(first), lowerEnds(second)),
              uppers[] = uvec4[](upperEnds(first), upperEnds(second));
        WRITE_TWO_OF_GROUP(outNodeBoxes, int(groupsAt) + node * 24, k, lowers, uppers)
        lower = min(lower, min(lowers[0], lowers[1]));
        upper = max(upper, max(uppers[0], uppers[1]));
    }
    uvec4 box = packBox(lower, upper);
    for (int word = 0; word < 4; word++)
        outNodeBoxes[node * 4 + word] = box[word];
    // Nodes outside the AABB of their body's partners are skipped.
    uint body = texelFetch(nodes, node).x;
    if (IS_OF_INTEREST(box, body))
    {
        uvec3 first = lower.xyz >> cellShift, last = upper.xyz >> cellShift, size = last - first + 1u;
        uint count = size.x * size.y * size.z;
        uint index = append(entryCounter, count), end = index + count;
        for (uvec3 at = first; index != end && index < entryCapacity; index++)
        {
            uint cell = cellAt(at), next = atomicExchange(counters[COUNTER_WORDS + cell], index);
            outEntries[index] = uvec4(uint(node), next, cell, body);
            at.x++;
            at = at.x > last.x ? uvec3(first.x, at.y + 1u, at.z) : at;
            at = at.y > last.y ? uvec3(first.xy, at.z + 1u) : at;
        }
        // Some implementations stop the loops of an invocation after 65 535 iterations in all.
        if (index < min(end, entryCapacity))
            counters[stoppedCounter] = 1u;
    }
    else
        atomicAdd(counters[skippedCounter], 1u);
}
