// The triangles of two clusters against each other, neighbours left out.
layout(std430, binding = 1) buffer TrianglePairs { uint outTrianglePairs[]; }; // cluster pair << 6 | triangle + 8 * triangle
uniform uint clusterPairCapacity, trianglePairCapacity, testNeighbours;

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
    uvec2 mask = texelFetch(tables, int(hasTable ? table * 64u + bit : 0u)).xy;
    mask = hasTable ? mask : a == b ? uvec2(0x07030100u, 0x7f3f1f0fu) : uvec2(none);
    EIGHT_AGAINST_EIGHT(boxes, int(a * 8u), int(b * 8u), mask)
    WRITE_BITS(outTrianglePairs, trianglePairCapacity, trianglePairCounter, i, mask)
}
