import { DataTexture, DataUtils, FileLoader, HalfFloatType, LinearFilter, LoaderUtils, RGBAFormat } from 'three';

// Rows with the first on top, as the coordinates of glTF read them.
function textureOf( data, width, height ) {
	const map = new DataTexture( data, width, height, RGBAFormat, HalfFloatType );
	map.minFilter = map.magFilter = LinearFilter;
	map.channel = 1; // TEXCOORD_1
	map.needsUpdate = true;
	return map;
}

// Of what EXRLoader.parse returns, whose rows have the last first.
export function mapOfEXR( { data, width, height } ) {
	const row = 4 * width, out = new Uint16Array( row * height );
	for ( let y = 0; y < height; y ++ ) {
		const from = data.subarray( row * ( height - 1 - y ), row * ( height - y ) );
		out.set( from instanceof Uint16Array ? from : Array.from( from, DataUtils.toHalfFloat ), row * y );
	}
	return textureOf( out, width, height );
}

// Of the bytes of a .ktx2 of ylm: halves of red, green, blue and alpha, one level.
export function mapOfKTX2( bytes ) {
	const words = new DataView( bytes ), width = words.getUint32( 20, true ), height = words.getUint32( 24, true );
	const at = Number( words.getBigUint64( 80, true ) );
	if ( words.getUint32( 12, true ) !== 97 ) throw new Error( 'a .ktx2 of half floats is wanted' );
	return textureOf( new Uint16Array( bytes.slice( at, at + 8 * width * height ) ), width, height );
}

// Of the bytes of a .png: irradiance is range ( a rgb )^2. WebGL reads them as they stand; a 2D canvas would multiply by alpha.
export async function mapOfPNG( bytes, range ) {
	const image = await createImageBitmap( new Blob( [ bytes ], { type: 'image/png' } ),
		{ premultiplyAlpha: 'none', colorSpaceConversion: 'none' } );
	const { width, height } = image, gl = new OffscreenCanvas( 1, 1 ).getContext( 'webgl2' );
	gl.pixelStorei( gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE );
	gl.bindTexture( gl.TEXTURE_2D, gl.createTexture() );
	gl.texImage2D( gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image );
	gl.bindFramebuffer( gl.FRAMEBUFFER, gl.createFramebuffer() );
	gl.framebufferTexture2D( gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, gl.getParameter( gl.TEXTURE_BINDING_2D ), 0 );
	const from = new Uint8Array( 4 * width * height ), out = new Uint16Array( from.length );
	gl.readPixels( 0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, from );
	gl.getExtension( 'WEBGL_lose_context' )?.loseContext();
	for ( let i = 0; i < out.length; i += 4 ) {
		for ( let c = 0; c < 3; c ++ )
			out[ i + c ] = DataUtils.toHalfFloat( range * ( from[ i + 3 ] * from[ i + c ] / 65025 ) ** 2 );
		out[ i + 3 ] = 0x3c00; // 1
	}
	return textureOf( out, width, height );
}

// Lights the meshes of a scene of GLTFLoader by a map: irradiance, so that the factor is 1.
export function lightBy( scene, map ) {
	scene.traverse( o => {
		if ( ! o.isMesh || ! o.geometry.attributes.uv1 ) return;
		o.material = o.material.clone();
		o.material.lightMap = map;
		o.material.lightMapIntensity = 1;
	} );
}

// What a file of ylm says of its lightmap, and the map itself if it is inside; `bytes` are those of the picture beside it.
export async function mapOf( gltf, bytes, EXRLoader ) {
	const { json } = gltf.parser, about = json.scenes[ 0 ].extras.ylm.lightmap;
	if ( about.texture !== undefined ) {
		const image = json.images[ json.textures[ about.texture ].source ];
		return mapOfPNG( await gltf.parser.getDependency( 'bufferView', image.bufferView ), about.range );
	}
	if ( about.range ) return mapOfPNG( bytes, about.range );
	return about.file.endsWith( '.ktx2' ) ? mapOfKTX2( bytes ) : mapOfEXR( new EXRLoader().parse( bytes ) );
}

// scene.add( ( await loadLightmapped( 'room.glb', new GLTFLoader(), EXRLoader ) ).scene );
export async function loadLightmapped( url, loader, EXRLoader ) {
	const gltf = await loader.loadAsync( url ), { file } = gltf.parser.json.scenes[ 0 ].extras.ylm.lightmap;
	const at = LoaderUtils.extractUrlBase( url ) + file, files = new FileLoader().setResponseType( 'arraybuffer' );
	lightBy( gltf.scene, await mapOf( gltf, file && await files.loadAsync( at ), EXRLoader ) );
	return gltf;
}
