// Overlapping triangles of two clusters, except neighbours.
layout(std430, binding = 1) buffer TrianglePairs { uint outTrianglePairs[]; }; // cluster pair << 6 | triangle + 8 * triangle
uniform uint clusterPairCapacity, trianglePairCapacity, testNeighbours;

// The pair mask of two clusters, see qcPairMask_Word; none where the table has no word.
uvec2 wordOf(uint table, uint bit)
{
    uvec2 some = texelFetch(tables, int(table)).xy, empty = texelFetch(tables, int(table + 1u)).xy;
    uint flagBit = 1u << (bit & 31u);
    uvec2 flag = bit < 32u ? uvec2(flagBit, 0u) : uvec2(0u, flagBit);
    uvec2 below = bit < 32u ? uvec2(flagBit - 1u, 0u) : uvec2(none, flagBit - 1u);
    ivec2 ranks = bitCount(some & below);
    uvec2 word = texelFetch(tables, int(table) + 2 + ranks.x + ranks.y).xy;
    return (some & flag) != uvec2(0u) ? word : (empty & flag) != uvec2(0u) ? uvec2(0u) : uvec2(none);
}

void main()
{
    uint i = ITEM;
    if (i >= countOf(clusterPairCounter, clusterPairCapacity))
        return;

    uint word = texelFetch(clusterPairs, int(i)).x, bit = word & 63u;
    uvec2 pair = texelFetch(nodePairs, int(word >> 6)).xy;
    uint table = texelFetch(nodePairTables, int(word >> 6)).x;
    uint a = pair.x * 8u + (bit & 7u), b = pair.y * 8u + (bit >> 3);
    bool hasTable = table != none && testNeighbours == 0u;
    uvec2 mask = wordOf(hasTable ? table : 0u, bit);
    mask = hasTable ? mask : a == b ? uvec2(0x07030100u, 0x7f3f1f0fu) : uvec2(none);
    EIGHT_AGAINST_EIGHT(boxes, int(a * 8u), int(b * 8u), mask)
    WRITE_BITS(outTrianglePairs, trianglePairCapacity, trianglePairCounter, i, mask)
}
