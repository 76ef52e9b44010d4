// Rigid bodies: from local space to the frame. A chunk is 64 vertices of one body.
layout(std430, binding = 1) buffer Vertices { vec4 outVertices[]; };
uniform samplerBuffer locals; // xyz about the body's centre, w: the body's place
uniform usamplerBuffer chunks;
uniform uint chunkCount;

void main()
{
    uint i = ITEM;
    if (i >= chunkCount * 64u)
        return;

    int v = int(texelFetch(chunks, int(i >> 6)).x * 64u + (i & 63u));
    vec4 local = texelFetch(locals, v);
    int body = int(floatBitsToUint(local.w)) * BODY_TEXELS;
    vec4 x = uintBitsToFloat(texelFetch(bodies, body + 2)), y = uintBitsToFloat(texelFetch(bodies, body + 3)),
         z = uintBitsToFloat(texelFetch(bodies, body + 4));
    outVertices[v] = vec4(dot(x.xyz, local.xyz) + x.w, dot(y.xyz, local.xyz) + y.w, dot(z.xyz, local.xyz) + z.w, 0.0);
}
